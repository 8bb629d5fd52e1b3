"""Progress of sweeps, and Dask."""

import os
import pty
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.api.progress import Progress
from hydrofdi.config import RunParameters
from hydrofdi.execution.compute import split_jobs
from hydrofdi.execution.measuring import Job
from runner.processes import COMMAND, kill, run, run_json, start, wait_until
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


pytest.importorskip("distributed", reason="the extra 'dask' is not installed")

CONFIG = """\
name: spread
record: {duration: 8 s}
store: {signals: none}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min, 2 L/min]
    fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 400]}
"""


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two workers."""
    log = tmp_path / "scheduler.log"
    processes = []

    def begin(*arguments, to):
        with open(to, "w") as output:
            processes.append(
                subprocess.Popen(
                    [sys.executable, "-m", *arguments], stdout=output, stderr=output, cwd=tmp_path
                )
            )
        return processes[-1]

    try:
        begin(
            "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", to=log
        )
        found = wait_until(lambda: re.search(r"Scheduler at:\s*(tcp://127\.0\.0\.1:\d+)", log.read_text()))
        address = found.group(1)
        options = ["--nthreads", "1", "--no-dashboard", "--host", "127.0.0.1", "--no-nanny"]
        crew = [
            begin("distributed.cli.dask_worker", address, *options, to=tmp_path / f"worker{k}.log")
            for k in (1, 2)
        ]
        assert wait_until(lambda: log.read_text().count("Register worker") == 2)
        yield address, crew
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


@pytest.mark.parametrize(
    "sharing", ["--shared-directory", pytest.param("--no-shared-directory", marks=pytest.mark.long)]
)
def test_a_lost_worker_loses_nothing_and_the_bits_are_those_of_a_local_sweep(tmp_path, cluster, sharing):
    address, crew = cluster
    file = tmp_path / "spread.yaml"
    file.write_text(CONFIG)
    there, here = tmp_path / "there" / "spread", tmp_path / "here" / "spread"
    process = start("sweep", file, "--out", there, "--engine", "dask", "--scheduler", address, sharing)
    assert wait_until(lambda: list((there / "shards").glob("[!.]*.h5")) or process.poll() is not None)
    kill(crew[0].pid)
    _, complaints = process.communicate(timeout=120)
    assert process.returncode == 0, complaints
    run("sweep", file, "--out", here, check=0)
    assert (there / "spread.h5").read_bytes() == (here / "spread.h5").read_bytes()
    assert run_json("verify", there)["sound"]


def test_an_absent_scheduler_is_reported_in_one_line(tmp_path):
    file = tmp_path / "spread.yaml"
    file.write_text(CONFIG)
    reported = run("sweep", file, "--out", tmp_path / "x", "--engine", "dask", check=2).stderr
    assert "needs scheduler" in reported
    address = "tcp://127.0.0.1:9"
    reported = run(
        "sweep", file, "--out", tmp_path / "x", "--engine", "dask", "--scheduler", address, check=2
    ).stderr
    assert "no answer" in reported
    assert not (tmp_path / "x").exists()
