"""What a person sees while a sweep runs, and what an interruption says."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.api.progress import Progress
from hydrofdi.config import RunParameters
from hydrofdi.execution.compute import split_jobs
from hydrofdi.execution.measuring import Job
from runner.processes import COMMAND, run, start, wait_until
from tests.commands import run_hydrofdi

DRIFTING = """\
name: drifting
record: {duration: 4 s}
store: {signals: none}
sweep: {grid: {leakage.internal_flow: [0 L/min, 0.2 L/min], fluid.bulk_modulus: [551 MPa, 689 MPa]}}
"""

SLOW = """\
name: slow
record: {duration: 400 s, sampling_frequency: 2 kHz, step: 0.01 ms}
store: {signals: none}
sweep: {grid: {fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 200]}}}
"""


@pytest.fixture
def drifting(tmp_path: Path) -> Path:
    file = tmp_path / "drifting.yaml"
    file.write_text(DRIFTING)
    return file


def test_a_sweep_ends_with_verdicts_and_remedies(drifting: Path) -> None:
    out = drifting.parent / "out"
    told = run_hydrofdi("sweep", drifting, "--out", out, "--engine", "in-process").stderr
    assert "4 of 4 runs to compute with 1 worker\n" in told
    assert told.index("runs to compute") < told.index("unsettled: lengthen")
    assert re.search(r"^\d unsettled: lengthen record\.duration by some periods", told, re.MULTILINE)


def test_python_is_told_of_coefficients_and_of_runs(drifting: Path) -> None:
    seen: list[Progress] = []
    results = hydrofdi.sweep(drifting, out=drifting.parent / "out", engine="in-process", progress=seen.append)
    for what, total in (("leakage coefficients K_i solved before the runs", 1), ("runs", 4)):
        own = [each for each in seen if each.what == what]
        assert [own[0].done, own[-1].done, own[-1].total] == [0, total, total]
    assert results.summary is not None
    assert results.summary.verdicts["unsettled"] > 0


def test_a_silent_sweep_says_nothing(drifting: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hydrofdi.sweep(drifting, out=drifting.parent / "out", engine="in-process")
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


@pytest.mark.parametrize(
    "group", [False, True], ids=["the command alone", "all processes, as a terminal does"]
)
def test_an_interrupt_before_the_first_run_says_that_nothing_was_stored(tmp_path: Path, group: bool) -> None:
    file = tmp_path / "slow.yaml"
    file.write_text(SLOW)
    process = start("sweep", file, "--out", tmp_path / "out")
    assert wait_until(lambda: (tmp_path / "out" / "run.log").exists())
    send = os.killpg if group else os.kill
    send(process.pid, signal.SIGINT)
    assert process.stderr is not None
    assert any("press Ctrl-C again" in line for line in iter(process.stderr.readline, ""))
    send(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted before the first run ended; nothing was stored\n" in told
    assert "Traceback" not in told


def test_an_interrupt_while_the_fork_server_starts_leaves_no_traceback(tmp_path: Path) -> None:
    file = tmp_path / "slow.yaml"
    file.write_text(SLOW)
    process = start("sweep", file, "--out", tmp_path / "out")
    assert process.stderr is not None
    assert any("runs to compute" in line for line in iter(process.stderr.readline, ""))
    os.killpg(process.pid, signal.SIGINT)
    if not wait_until(lambda: process.poll() is not None, 3.0):  # it finishes the runs in progress
        os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in told


def test_an_interrupted_sweep_says_how_many_runs_are_stored(tmp_path: Path) -> None:
    file = tmp_path / "long.yaml"
    file.write_text(SLOW.replace("400 s", "20 s").replace("0.01 ms", "0.1 ms").replace("200", "3000"))
    process = start("sweep", file, "--out", tmp_path / "out")
    assert wait_until(lambda: list((tmp_path / "out" / "shards").glob("[!.]*.h5")))
    os.kill(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=120)
    done = int(re.search(r"([\d,]+) planned, ([\d,]+) done", run("status", tmp_path / "out").stdout)[2])  # type: ignore[index]
    assert f"interrupted; runs stored: {done:,} of 3,000; the same command continues from there" in told
