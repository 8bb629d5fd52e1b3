"""Progress of sweeps, and Dask."""

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

import hydrofdi
from hydrofdi.api.progress import Progress
from hydrofdi.config import RunParameters
from hydrofdi.execution.compute import split_jobs
from hydrofdi.execution.measuring import Job
from tests.commands import COMMAND, run, run_json
from tests.runner.processes import kill, shards, start, wait_until

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


def test_python_is_told_of_coefficients_and_of_runs_where_it_asks(drifting: Path, capsys) -> None:
    seen: list[Progress] = []
    results = hydrofdi.sweep(drifting, out=drifting.parent / "out", engine="in-process", progress=seen.append)
    for what, total in (("leakage coefficients K_i solved before the runs", 1), ("runs", 4)):
        own = [each for each in seen if each.what == what]
        assert [own[0].done, own[-1].done, own[-1].total] == [0, total, total]
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


CONFIG = """\
name: spread
record: {duration: 8 s}
store: {signals: none}
sweep:
  grid:
    leakage.internal_flow: [0 L/min, 0.12 L/min, 0.89 L/min, 2 L/min]
    fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 150]}
"""


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two workers."""
    log, processes = tmp_path / "scheduler.log", []

    def begin(kind, *arguments, to):
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *arguments, "--no-dashboard"]
        with open(to, "w") as output:
            processes.append(
                subprocess.Popen(
                    [*command, "--host", "127.0.0.1"], stdout=output, stderr=output, cwd=tmp_path
                )
            )
        return processes[-1]

    try:
        begin("scheduler", "--port", "0", to=log)
        found = wait_until(lambda: re.search(r"Scheduler at:\s*(tcp://127\.0\.0\.1:\d+)", log.read_text()))
        options = [found.group(1), "--nthreads", "1", "--no-nanny"]
        crew = [begin("worker", *options, to=tmp_path / f"worker{k}.log") for k in (1, 2)]
        assert wait_until(lambda: log.read_text().count("Register worker") == 2)
        yield found.group(1), crew
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
    assert wait_until(lambda: shards(there) or process.poll() is not None)
    kill(crew[0].pid)
    _, complaints = process.communicate(timeout=120)
    assert process.returncode == 0, complaints
    run("sweep", file, "--out", here, check=0)
    assert (there / "spread.h5").read_bytes() == (here / "spread.h5").read_bytes()
    assert run_json("verify", there)["sound"]


def test_an_absent_scheduler_is_reported_in_one_line(drifting: Path, monkeypatch) -> None:
    monkeypatch.setattr("hydrofdi.execution.dask_cluster.PATIENCE", "0.5s")
    sweep = ("sweep", drifting, "--out", drifting.parent / "x", "--engine", "dask")
    assert "needs scheduler" in run(*sweep, check=2).stderr
    assert "no answer" in run(*sweep, "--scheduler", "tcp://127.0.0.1:9", check=2).stderr
    assert not (drifting.parent / "x").exists()
