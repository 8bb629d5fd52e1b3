"""That a command in this process is the command in a process of its own."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.commands import run_hydrofdi, run_process

SHORT = "--set=record.duration=2 s"


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ((), 0),
        (("report", "--help"), 0),
        (("simulate", SHORT), 0),
        (("simulate", SHORT, "--set=fluid.bulk_modulus=1e13"), 1),
        (("simulate", "--set=fluid.bulk=1"), 2),
        (("swep",), 2),
    ],
)
def test_output_and_exit_code_are_those_of_a_process(
    arguments: tuple[str, ...], code: int, tmp_path: Path
) -> None:
    here, there = (run(*arguments, cwd=tmp_path) for run in (run_hydrofdi, run_process))
    assert here.returncode == there.returncode == code
    assert (here.stdout, here.stderr) == (there.stdout, there.stderr)


def test_a_fault_is_a_traceback_and_exit_code_3(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hydrofdi.config.load_experiment", None)
    done = run_hydrofdi("simulate", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert "Traceback" in done.stderr
    assert "'NoneType' object is not callable" in done.stderr


def test_nothing_of_a_command_stays_behind(tmp_path: Path) -> None:
    before = dict(os.environ), os.getcwd()
    (tmp_path / "sweep.yaml").write_text("record: {duration: 2 s}\nstore: {signals: none}\n")
    assert run_hydrofdi("sweep", "sweep.yaml", "--workers", "2", cwd=tmp_path).returncode == 0
    assert (dict(os.environ), os.getcwd()) == before
