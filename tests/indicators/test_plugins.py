"""Indicators in Python files that an experiment names: the one of docs/indicators.md, and faulty ones."""

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import hydrofdi
from hydrofdi.config.experiment import IndicatorChoice
from hydrofdi.errors import ConfigError
from tests.commands import run, run_process

PAGE = Path(__file__).parents[2] / "docs" / "indicators.md"
(SWING,) = re.findall(r"as swing.py -->\s*```python\n(.*?)```", PAGE.read_text(), re.DOTALL)

EXPERIMENT = """\
name: swings
record: {duration: 1 s}
plugins: swing.py
indicators: [dwt, swing]
sweep: {grid: {fluid.bulk_modulus: [551 MPa, 827 MPa]}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the file of the page and an experiment."""
    (tmp_path / "swing.py").write_text(SWING)
    (tmp_path / "swings.yaml").write_text(EXPERIMENT)
    return tmp_path


def stored(folder: Path) -> dict[str, Any]:
    """What the experiment file holds."""
    with h5py.File(folder / "results" / "swings.h5") as file:
        texts = {name: file[name].asstr()[:].tolist() for name in file if name.endswith("_id")}
        values = {name: file[name][:] for name in ("swing.range", "chamber_1_pressure")}
        return texts | values | {"indicator": file["swing.analysis_id"].attrs["indicator"]}


def test_workers_measure_it_and_its_path_and_hash_are_stored(folder: Path) -> None:
    done = run_process("sweep", folder / "swings.yaml", "--workers", "2", "--out", folder / "results")
    assert done.returncode == 0, done.stderr
    found, digest = stored(folder), hashlib.sha256(SWING.encode()).hexdigest()
    np.testing.assert_array_equal(found["swing.range"], np.ptp(found["chamber_1_pressure"], axis=1))
    assert found["indicator"] == f"swing@{digest[:16]}"
    request = json.loads((folder / "results" / "experiment.json").read_text())
    (provenance,) = json.loads((folder / "results" / "provenance.json").read_text())
    assert request["plugins"] == provenance["configuration"]["plugins"] == {str(folder / "swing.py"): digest}


def test_neither_the_place_of_a_file_nor_who_takes_it_is_part_of_its_identity(folder: Path) -> None:
    digest = hashlib.sha256(SWING.encode()).hexdigest()[:16]
    stored_choice = IndicatorChoice(json.dumps({"swing": {"kind": f"swing@{digest}"}}))
    named = hydrofdi.load_experiment(folder / "swings.yaml").indicator_choice
    assert not stored_choice.absent
    (folder / "other").mkdir()
    (folder / "swing.py").rename(folder / "other" / "moved.py")
    (folder / "swings.yaml").write_text(EXPERIMENT.replace("swing.py", "other/moved.py"))
    assert hydrofdi.load_experiment(folder / "swings.yaml").indicator_choice.identity == named.identity
    sliding = {"of": "swing", "window": "0.2 s", "interval": "0.1 s"}
    indicators = {"mine": {"kind": "swing"}, "sliding": sliding}
    study = {"record": {"duration": "1 s"}, "plugins": [folder / "other/moved.py"], "indicators": indicators}
    assert hydrofdi.load_experiment(study).indicator_choice.identity.count(f"swing@{digest}") == 2


def test_a_results_folder_does_not_have_it_executed(folder: Path) -> None:
    marker = folder / "executed"
    (folder / "swing.py").write_text(f"{SWING}\nopen({str(marker)!r}, 'w').close()\n")
    sliding = "{dwt: {}, swing: {}, sliding: {of: swing, window: 0.2 s, interval: 0.1 s, transient: 0.1 s}}"
    (folder / "swings.yaml").write_text(EXPERIMENT.replace("[dwt, swing]", sliding))
    out = folder / "results"
    hydrofdi.sweep(folder / "swings.yaml", out=out, engine="in-process")
    marker.unlink()
    for command in (("report", out), ("status", out), ("why", out, "1"), ("verify", out)):
        assert run_process(*command).returncode == 0
    here, elsewhere = run("report", out, "--json").stdout, run_process("report", out, "--json").stdout
    assert here == elsewhere
    assert run_process("rerun", out, "1").returncode == 2
    assert not marker.exists()
    again = run_process("rerun", out, "1", "--config", folder / "swings.yaml")
    assert again.returncode == 0, again.stderr
    assert marker.exists()
    (folder / "swing.py").unlink()
    assert run_process("report", out, "--json").stdout == here
    (out / "swings.h5").unlink()  # as while a sweep runs
    assert "2 done" in run_process("status", out).stdout
    assert "Indicator swing is omitted" in run_process("report", out, "--format", "markdown").stdout
    assert run_process("collect", out).returncode == 2


@pytest.mark.parametrize(
    ("content", "stated", "said", "where"),
    [
        (None, "swing.py", "No such file", ":3: plugins"),
        ("x = 1\n\n1 / 0\n", "swing.py", "swing.py:3", ":3: plugins"),
        ("x = 1\nx = = 2\n", "swing.py", "line 2", ":3: plugins"),
        ("x = 1\n", "swing.py", "no indicator", ":3: plugins"),
        (SWING.replace('"swing", 1', '"dwt", 1'), "swing.py", "'dwt'", ":3: plugins"),
        (SWING.replace("version, source", "note, source"), "swing.py", "version", ":3: plugins"),
        (SWING.replace('"swing", 1', '"my swing", 1'), "swing.py", "'my swing'", ":3: plugins"),
        (SWING, "\n- swing.py\n- other.py", "'swing'", ":5: plugins[1]"),
        (SWING, "3", "plugins", ":3: plugins"),
        (SWING, "[swing.py, 4]", "plugins", ":3: plugins"),
    ],
)
def test_a_faulty_file_is_refused_at_the_line_that_names_it(folder, content, stated, said, where) -> None:
    file = folder / "swing.py"
    (folder / "other.py").write_text(SWING + "\n")
    (folder / "swings.yaml").write_text(EXPERIMENT.replace("swing.py", stated))
    file.unlink() if content is None else file.write_text(content)
    with pytest.raises(ConfigError, match=re.escape(said)) as error:
        hydrofdi.load_experiment(folder / "swings.yaml")
    (mistake,) = error.value.mistakes
    assert f"{mistake.origin}: {mistake.where}" == f"{folder / 'swings.yaml'}{where}"
