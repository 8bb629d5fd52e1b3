"""A sweep on a real Dask scheduler with two workers on loopback."""

import re
import subprocess
import sys

import pytest

from runner.processes import kill, run, run_json, start, wait_until

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
