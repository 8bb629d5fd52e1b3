"""An indicator of another package: the one of docs/indicators.md, installed and measured."""

import csv
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from hydrofdi.indicators import registry
from tests.commands import run, run_json, run_process

PAGE = Path(__file__).parents[2] / "docs" / "indicators.md"
MUSEUM = Path(__file__).parents[1] / "museum" / "format_4_physics_3" / "pressures.h5"
CACHES = (registry._added, registry.indicator_kind)


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where Python finds the package of the page as if pip had installed it."""
    (code,) = re.findall(r"as swing.py -->\s*```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (point,) = re.findall(r"entry point `(.*?)`", PAGE.read_text())
    package, information = tmp_path / "packages", tmp_path / "packages" / "swing-1.0.dist-info"
    information.mkdir(parents=True)
    (package / "swing.py").write_text(code)
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: swing\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text("[hydrofdi.indicators]\n" + point.replace('"', ""))
    monkeypatch.syspath_prepend(package)
    monkeypatch.setenv("PYTHONPATH", str(package), prepend=os.pathsep)
    for cached in CACHES:
        cached.cache_clear()
    yield package
    sys.modules.pop("swing", None)
    for cached in CACHES:
        cached.cache_clear()


def test_it_is_listed_described_and_measured() -> None:
    with h5py.File(MUSEUM) as file:
        swings = np.ptp(file["chamber_1_pressure"][:], axis=1)
    assert "swing" in [indicator["name"] for indicator in run_json("indicators")["indicators"]]
    assert "largest less least pressure" in run("indicators", "swing", check=0).stdout
    measured = run_json("measure", MUSEUM, "--indicators", "swing,dwt")
    described = {"name": "swing.range", "unit": "Pa", "channels": ["chamber_1_pressure"]}
    assert measured["indicators"][0] == described
    assert [record["values"]["swing.range"] for record in measured["records"]] == swings.tolist()
    table = run("measure", MUSEUM, "--indicators", "swing", "--format", "csv", check=0).stdout
    assert [float(row["swing.range_Pa"]) for row in csv.DictReader(table.splitlines())] == swings.tolist()


def test_one_that_cannot_be_loaded_is_named_in_a_line(package: Path) -> None:
    (package / "swing.py").write_text("import nothing_of_this_name\n")
    done = run("measure", MUSEUM, "--indicators", "swing", check=2)
    assert "nothing_of_this_name" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "nothing_of_this_name" in run("indicators", check=2).stderr


def test_workers_of_a_sweep_store_it_beside_the_signals_and_results_are_read_without_its_package(
    package: Path, tmp_path: Path
) -> None:
    (tmp_path / "swings.yaml").write_text(
        "name: swings\nrecord: {duration: 1 s}\nindicators: [dwt, swing]\n"
        "sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}\n"
    )
    done = run_process("sweep", "swings.yaml", "--workers", "2", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "results" / "swings"
    sys.path.remove(str(package))
    assert "swing.range" in run("report", folder, "--format", "markdown").stdout
    with h5py.File(folder / "swings.h5", "r+") as file:
        stored = file["swing.range"]
        assert (stored.attrs["units"], stored.attrs["long_name"]) == ("Pa", "largest less least pressure")
        np.testing.assert_array_equal(stored[:], np.ptp(file["chamber_1_pressure"][:], axis=1))
        del file["swing.analysis_id"].attrs["outputs"]  # as in one of an earlier version
    assert "Indicator swing is omitted" in run("report", folder, "--format", "markdown").stdout
    for arguments in (("measure", folder, "--indicators", "dwt"), ("verify", folder)):
        run(*arguments, check=0)
    assert run_json("status", folder)["missing"] == 0
    for arguments in (("sweep", "swings.yaml", "--engine", "in-process"), ("collect", folder)):
        assert "there is no indicator 'swing'" in run(*arguments, cwd=tmp_path, check=2).stderr
