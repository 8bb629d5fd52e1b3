"""What Python and the command line offer: names, and a command as a process."""

from pathlib import Path

import pytest
import yaml

import hydrofdi
from tests.commands import run_hydrofdi, run_process
from tests.conftest import REPOSITORY


def test_the_public_names_are_few_documented_and_there_and_the_citation_has_their_version():
    assert len(hydrofdi.__all__) <= 37
    assert set(dir(hydrofdi)) == set(hydrofdi.__all__)
    for name in hydrofdi.__all__:
        assert name == "__version__" or getattr(hydrofdi, name).__doc__
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == hydrofdi.__version__


@pytest.mark.parametrize(
    ("setting", "code"), [("--set=record.duration=2 s", 0), ("--set=EBM=1e13", 1), ("-x", 2)]
)
def test_output_and_exit_code_are_those_of_a_process(setting: str, code: int, tmp_path: Path) -> None:
    here, there = (run("simulate", setting, cwd=tmp_path) for run in (run_hydrofdi, run_process))
    assert here.returncode == there.returncode == code
    assert (here.stdout, here.stderr) == (there.stdout, there.stderr)


def test_a_fault_is_a_traceback_and_exit_code_3(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydrofdi.load_experiment", None)
    done = run_hydrofdi("simulate", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert "Traceback" in done.stderr
    assert "'NoneType' object is not callable" in done.stderr
