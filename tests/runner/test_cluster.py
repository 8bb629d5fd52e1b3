"""Sweeps on a Dask cluster: what is lost there, and clusters that end."""

import os
import re
import signal
import subprocess
import sys

import pytest

from tests.commands import COMMAND, run, run_json
from tests.runner.processes import kill, shards, start, wait_until

LOCAL = ("--no-dashboard", "--host", "127.0.0.1")
IMPATIENT = """
import hydrofdi.execution.engines as cluster
cluster.MOST_SECONDS_WITHOUT_WORKERS = 3.0
from hydrofdi.cli.app import main
main()
"""


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, its process, and those of its two workers."""
    log, processes = tmp_path / "scheduler.log", []

    def begin(kind, *arguments, to):
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *LOCAL, *arguments]
        environment = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "5s"}
        with open(to, "w") as output:
            options = {"stdout": output, "stderr": output, "cwd": tmp_path, "env": environment}
            processes.append(subprocess.Popen(command, **options))

    try:
        begin("scheduler", "--port", "0", to=log)
        found = wait_until(lambda: re.search(r"Scheduler at:\s*(tcp://127\.0\.0\.1:\d+)", log.read_text()))
        options = [found.group(1), "--nthreads", "1", "--no-nanny"]
        for number in (1, 2):
            begin("worker", *options, to=tmp_path / f"worker{number}.log")
        wait_until(lambda: log.read_text().count("Register worker") == 2)
        yield found.group(1), processes
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def disturbed(cluster, file, out, number, whom, *options, command=COMMAND):
    """A sweep on the cluster, some of whose processes get a signal once a shard is stored."""
    address, processes = cluster
    sweep = ("sweep", file, "--out", out, "--engine", "dask", "--scheduler", address, *options)
    process = start(*sweep, command=command)
    try:
        wait_until(lambda: shards(out) or process.poll() is not None)
        for each in processes[whom]:
            kill(each.pid, number)
        _, told = process.communicate(timeout=120)
    finally:
        process.kill()
    return process.returncode, told


@pytest.mark.parametrize(("number", "sharing"), [
    (signal.SIGKILL, "--shared-directory"),
    pytest.param(signal.SIGKILL, "--no-shared-directory", marks=pytest.mark.long),
    pytest.param(signal.SIGSTOP, "--shared-directory", marks=pytest.mark.long),
])  # fmt: skip
def test_a_lost_worker_loses_nothing_and_the_bits_are_those_of_a_local_sweep(
    tmp_path, cluster, long, number, sharing
):
    file, whole = long
    code, told = disturbed(cluster, file, tmp_path / "long", number, slice(1, 2), sharing)
    assert code == 0, told
    assert (tmp_path / "long" / "long.h5").read_bytes() == whole
    assert run_json("verify", tmp_path / "long")["sound"]


@pytest.mark.parametrize(("number", "whom"), [
    (signal.SIGKILL, slice(0, 1)),
    pytest.param(signal.SIGKILL, slice(1, 3), marks=pytest.mark.long),
    pytest.param(signal.SIGSTOP, slice(1, 3), marks=pytest.mark.long),
], ids=["the scheduler is killed", "all workers are killed", "all workers are stopped"])  # fmt: skip
def test_a_cluster_that_ends_is_an_error_and_the_same_command_completes_to_the_same_bits(
    tmp_path, cluster, long, number, whom
):
    (file, whole), out = long, tmp_path / "long"
    code, told = disturbed(cluster, file, out, number, whom, command=[sys.executable, "-c", IMPATIENT])
    assert (code, "Traceback" in told) == (2, False), told
    (error,) = [line for line in told.splitlines() if line.startswith("hydrofdi: ")]
    stored = int(re.search(r"runs stored: (\d+) of 600; the same command continues", error).group(1))
    for process in cluster[1]:
        process.kill()
        process.wait()
    done = run_json("status", out)["done"]
    assert 0 < stored <= done < 600  # a worker may have stored more since
    assert run_json("sweep", file, "--out", out)["completed"] == 600 - done
    assert (out / "long.h5").read_bytes() == whole


def test_an_absent_scheduler_is_reported_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr("hydrofdi.execution.engines.PATIENCE", "0.5s")
    sweep = ("sweep", "smoke", "--out", tmp_path / "x", "--engine", "dask")
    assert "needs scheduler" in run(*sweep, check=2).stderr
    assert "no answer" in run(*sweep, "--scheduler", "tcp://127.0.0.1:9", check=2).stderr
    assert not (tmp_path / "x").exists()
