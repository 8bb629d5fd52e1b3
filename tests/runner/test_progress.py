"""Progress of sweeps."""

import os
import pty
import subprocess
from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.config import RunParameters
from hydrofdi.execution.compute import Job, split_jobs
from tests.commands import COMMAND, run

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


def test_a_sweep_ends_with_verdicts_and_remedies(drifting: Path) -> None:
    told = run("sweep", drifting, "--out", drifting.parent / "out", "--engine", "in-process").stderr
    assert "4 of 4 runs to compute with 1 worker\n" in told
    assert told.index("runs to compute") < told.index("unsettled: lengthen record.duration")


def test_python_is_told_of_runs_where_it_asks(drifting: Path, capsys) -> None:
    results = hydrofdi.sweep(drifting, out=drifting.parent / "out", engine="in-process", progress=True)
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
    try:
        while part := os.read(parent, 65536):
            text += part
    except OSError:  # the terminal is closed
        pass
    assert process.wait(60) == 0
    assert b"] 0 of 4 runs, " in text
    assert b"] 4 of 4 runs, " in text
    last = text.rpartition(b" of 4 runs, ")[2]
    assert b"\r" in last
    assert b"runs" in last


def test_the_bar_moves_at_least_thirty_times_over_records_of_usual_length() -> None:
    jobs = [Job(str(number), RunParameters(), 0.0) for number in range(1000)]
    batches = split_jobs(jobs, workers=2)
    assert len(batches) >= 30
    assert [job.run_id for batch in batches for job in batch] == [job.run_id for job in jobs]
