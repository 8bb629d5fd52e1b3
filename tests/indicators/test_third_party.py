"""An indicator of another package: the one of docs/indicators.md, installed and measured."""

import csv
import json
import os
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.commands import run_hydrofdi, run_process

PAGE = Path(__file__).parents[2] / "docs" / "indicators.md"
MUSEUM = Path(__file__).parents[1] / "museum" / "format_4_physics_3" / "pressures.h5"


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """Where Python finds the package of the page as if pip had installed it."""
    (code,) = re.findall(r"<!-- a test installs this -->\s*```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (points,) = re.findall(
        r"```toml\n\[project\.entry-points\.\"hydrofdi\.indicators\"\]\n(.*?)```", PAGE.read_text(), re.DOTALL
    )
    package, information = tmp_path / "packages", tmp_path / "packages" / "swing-1.0.dist-info"
    information.mkdir(parents=True)
    (package / "swing.py").write_text(code)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: swing\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text("[hydrofdi.indicators]\n" + points.replace('"', ""))
    return os.environ | {"PYTHONPATH": str(package)}


def output_of(environment: dict[str, str], *arguments: str | Path) -> str:
    done = run_process(*arguments, env=environment)
    assert done.returncode == 0, done.stderr
    return str(done.stdout)


def test_it_is_listed_described_and_measured(environment: dict[str, str]) -> None:
    with h5py.File(MUSEUM) as file:
        swings = np.ptp(file["chamber_1_pressure"][:], axis=1)
    listed = json.loads(output_of(environment, "indicators", "--json"))["indicators"]
    assert "swing" in [indicator["name"] for indicator in listed]
    assert "largest less least pressure" in output_of(environment, "indicators", "swing")
    measured = json.loads(output_of(environment, "measure", MUSEUM, "--indicators", "swing,dwt", "--json"))
    assert measured["indicators"][0] == {
        "name": "swing.range", "unit": "Pa", "channels": ["chamber_1_pressure"],
    }  # fmt: skip
    assert [record["values"]["swing.range"] for record in measured["records"]] == swings.tolist()
    table = output_of(environment, "measure", MUSEUM, "--indicators", "swing", "--format", "csv")
    assert [float(row["swing.range_Pa"]) for row in csv.DictReader(table.splitlines())] == swings.tolist()


def test_a_sweep_stores_it_beside_the_signals(environment: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "swings.yaml").write_text(
        "name: swings\nrecord: {duration: 1 s}\nindicators: [dwt, swing]\n"
        "sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}\n"
    )
    done = run_process("sweep", "swings.yaml", "--workers", "2", env=environment, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "results" / "swings" / "swings.h5") as file:
        stored = file["swing.range"]
        assert stored.attrs["units"] == "Pa"
        assert stored.attrs["long_name"] == "largest less least pressure"
        np.testing.assert_array_equal(stored[:], np.ptp(file["chamber_1_pressure"][:], axis=1))


def test_one_that_cannot_be_loaded_is_named_in_a_line(environment: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "packages" / "swing.py").write_text("import nothing_of_this_name\n")
    done = run_process("measure", MUSEUM, "--indicators", "swing", env=environment)
    assert done.returncode == 2
    assert done.stderr.startswith("hydrofdi: swing: ")
    assert "nothing_of_this_name" in done.stderr
    for arguments, shown in (
        (["indicators"], "dwt"), (["measure", MUSEUM, "--indicators", "all", "--json"], "dwt.d1"),
    ):  # fmt: skip
        done = run_process(*arguments, env=environment)
        assert done.returncode == 0
        assert "warning: indicator 'swing'" in done.stderr
        assert shown in done.stdout


def test_results_are_read_without_its_package(environment: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "swings.yaml").write_text("name: swings\nrecord: {duration: 1 s}\nindicators: [dwt, swing]\n")
    sweep = ("sweep", "swings.yaml", "--engine", "in-process")
    assert run_process(*sweep, env=environment, cwd=tmp_path).returncode == 0
    folder = tmp_path / "results" / "swings"
    assert "Indicator swing is omitted" in run_hydrofdi("report", folder, "--format", "markdown").stdout
    assert run_hydrofdi("measure", folder, "--indicators", "dwt", "--json").returncode == 0
    for command in ("verify", "status"):
        done = run_hydrofdi(command, folder)
        assert done.returncode == 0, done.stderr
    assert json.loads(run_hydrofdi("status", folder, "--json").stdout)["missing"] == 0
    for arguments in (sweep, ("collect", folder)):
        done = run_hydrofdi(*arguments, cwd=tmp_path)
        assert done.returncode == 2
        assert "there is no indicator 'swing'" in done.stderr
