"""Progress of sweeps."""

import contextlib
import os
import pty
import subprocess
from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.config import RunParameters
from hydrofdi.execution.compute import Job, split_jobs
from tests.commands import COMMAND

DRIFTING = """\
name: drifting
record: {duration: 4 s}
store: {signals: none}
sweep: {grid: {leakage.internal_flow: [0 L/min, 0.2 L/min], fluid.bulk_modulus: [551 MPa, 689 MPa]}}
"""


@pytest.fixture
def drifting(tmp_path: Path) -> Path:
    file = tmp_path / "drifting.yaml"
    file.write_text(DRIFTING)
    return file


def test_python_is_told_of_runs_where_it_asks(drifting: Path, capsys) -> None:
    results = hydrofdi.sweep(drifting, out=drifting.parent / "told", engine="in-process", progress=True)
    assert "4 of 4 runs to compute with 1 worker\n" in capsys.readouterr().err
    assert results.summary is not None
    assert results.summary.verdicts["unsettled"] > 0
    hydrofdi.sweep(drifting, out=drifting.parent / "silent", engine="in-process")
    assert capsys.readouterr() == ("", "")


def test_a_terminal_shows_a_bar_and_takes_it_away(drifting: Path) -> None:
    parent, child = pty.openpty()
    command = [*COMMAND, "sweep", str(drifting), "--out", str(drifting.parent / "out"), "--workers", "1"]
    process = subprocess.Popen(command, stderr=child, stdout=subprocess.DEVNULL)
    os.close(child)
    text = b""
    with contextlib.suppress(OSError):  # the terminal is closed
        while part := os.read(parent, 65536):
            text += part
    assert process.wait(60) == 0
    assert b"] 0 of 4 runs, " in text
    before, _, last = text.rpartition(b"] 4 of 4 runs, ")
    assert before
    assert b"\r" in last
    assert b"runs" in last


def test_the_bar_moves_at_least_thirty_times_over_records_of_usual_length() -> None:
    jobs = [Job(str(number), RunParameters(), 0.0) for number in range(1000)]
    batches = split_jobs(jobs, workers=2)
    assert len(batches) >= 30
    assert [job for batch in batches for job in batch] == jobs
