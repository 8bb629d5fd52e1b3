"""Runs that raise, hang, or lose their worker; disks that are full; folders that are not ours."""

import os
import resource
import shutil
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from hydrofdi.api.sweep import run_sweep
from hydrofdi.config.loading import load_experiment
from hydrofdi.errors import StoreError, SweepInterrupted
from hydrofdi.execution import InProcessEngine
from hydrofdi.execution.engine import TaskFailure
from runner.processes import COMMAND, kill, nobody_left, run, run_json, start, wait_until, workers

BAD_RUNS = """\
name: bad
record: {duration: 2 s, sampling_frequency: 10 kHz}
limits: {time_per_job: 5 s}
store: {signals: none}
sweep:
  union:
    - grid: {fluid.bulk_modulus: [551 MPa, 600 MPa, 689 MPa, 827 MPa]}
    - grid: {record.duration: [1000 s]}     # raises, where memory is limited
    - grid: {record.step: [1.0e-9 s]}       # hangs for all practical purposes
"""

LONG = """\
name: long
store: {signals: none}
sweep:
  grid:
    leakage.internal_coefficient: {linspace: [0, 3e-8, 40]}
    fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 80]}
"""


@pytest.fixture
def long_sweep(tmp_path):
    """A sweep of several seconds, and the folder of its results."""
    file = tmp_path / "long.yaml"
    file.write_text(LONG)
    return file, tmp_path / "long"


@pytest.fixture(scope="module")
def limit_memory():
    """Leaves a process the memory for ordinary runs, but not for a record of ten million samples."""
    code = (
        "from hydrofdi.config import RunParameters; from hydrofdi.execution.compute import *;"
        "compute_columns([Job('', RunParameters(), 0.0)]);"
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmPeak')))"
    )
    usual = 1024 * int(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout)
    limit = usual + 250_000_000
    return lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def test_runs_that_raise_or_hang_become_rows_and_the_others_finish(tmp_path, limit_memory):
    file, out = tmp_path / "bad.yaml", tmp_path / "bad"
    file.write_text(BAD_RUNS)
    summary = run_json("sweep", file, "--out", out, check=1, preexec_fn=limit_memory)
    assert (summary["planned"], summary["failed"]) == (6, 2)
    assert run_json("status", out, check=1)["statuses"] == {"ok": 4, "error": 1, "timeout": 1}
    rows = {row["status"]: row for row in run_json("report", out)["rows"]}
    assert "MemoryError" in rows["error"]["message"]
    assert "5 s" in rows["timeout"]["message"]
    assert "Traceback" in run_json("why", out, "4")["log"]
    again = run_json("sweep", file, "--out", out, check=1, preexec_fn=limit_memory)
    assert (again["completed"], again["failed"]) == (0, 2)
    retried = run_json("sweep", file, "--out", out, "--retry-failed", check=1, preexec_fn=limit_memory)
    assert (retried["completed"], retried["skipped"]) == (2, 4)


def test_a_run_whose_worker_is_killed_becomes_a_row_and_can_be_tried_again(tmp_path):
    file, out = tmp_path / "one.yaml", tmp_path / "one"
    file.write_text("name: one\nrecord: {duration: 2 s, step: 4.0e-7 s}\nstore: {signals: none}\n")
    process = start("sweep", file, "--out", out, "--workers", "1")
    assert wait_until(lambda: (out / "run.log").exists() and workers(process.pid))
    pids = wait_until(lambda: workers(process.pid))
    kill(pids[0])
    process.communicate(timeout=60)
    assert process.returncode == 1
    (failure,) = [row for row in run_json("report", out)["rows"] if row["status"] != "ok"]
    assert failure["status"] == "killed"
    assert run_json("sweep", file, "--out", out, "--retry-failed")["failed"] == 0


FLOWS = """\
name: flows
record: {duration: 2 s}
store: {signals: none}
sweep:
  union:
    - grid: {leakage.internal_flow: [0.1 L/min, 0.2 L/min, 0.3 L/min, 0.4 L/min]}
    - grid: {leakage.internal_coefficient: [1.0e-9]}
"""


class Losing(InProcessEngine):
    """Loses what solves K_i of 0.3 L/min, as if its worker were killed there or had no memory."""

    def __init__(self, status):
        super().__init__()
        self.status = status

    def completed(self):
        for result in super().completed():
            group = result.item[1] if isinstance(result.item, tuple) else ()
            if any(abs(each.leakage.internal_flow - 5e-6) < 1e-9 for each in group):
                result = replace(result, value=None, failure=TaskFailure(self.status, "lost"))
            yield result


@pytest.mark.parametrize("status", ["killed", "error"])
def test_what_is_lost_while_leaks_are_solved_becomes_a_row_and_can_be_tried_again(tmp_path, status):
    file, out = tmp_path / "flows.yaml", tmp_path / "flows"
    file.write_text(FLOWS)
    summary = run_sweep(load_experiment(file), out, Losing(status))
    assert (summary.statuses, summary.failed, summary.stored) == ({status: 1}, 1, 6)
    assert run_json("sweep", file, "--out", out, "--retry-failed")["statuses"] == {}


def test_a_worker_that_is_killed_while_leaks_are_solved_ends_no_sweep(tmp_path):
    file, out = tmp_path / "flows.yaml", tmp_path / "flows"
    file.write_text(FLOWS.replace("2 s", "2 s, step: 1.0e-5 s"))
    process = start("sweep", file, "--out", out, "--workers", "1")
    kill(wait_until(lambda: workers(process.pid))[0])
    _, reported = process.communicate(timeout=300)
    assert process.returncode == 0
    assert "Traceback" not in reported


def test_the_first_interrupt_stores_what_runs_and_the_sweep_goes_on_later(long_sweep):
    file, out = long_sweep
    process = start("sweep", file, "--out", out)
    assert wait_until(lambda: list((out / "shards").glob("[!.]*.h5")))
    os.kill(process.pid, signal.SIGINT)
    _, reported = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "the same command continues from there" in reported
    status = run_json("status", out)
    assert 0 < status["done"] < status["planned"]
    assert nobody_left(process.pid)
    summary = run_json("sweep", file, "--out", out)
    assert summary["completed"] == status["missing"]


@pytest.mark.parametrize("signals", [[signal.SIGINT, signal.SIGINT], [signal.SIGTERM], [signal.SIGKILL]])
def test_a_stop_leaves_no_process_and_nothing_that_a_reader_trips_over(long_sweep, signals):
    file, out = long_sweep
    process = start("sweep", file, "--out", out)
    assert wait_until(lambda: list((out / "shards").glob("[!.]*.h5")))
    for number in signals:
        os.kill(process.pid, number)
        wait_until(lambda: False, 0.3)
    process.wait(timeout=10)
    assert nobody_left(process.pid)
    if signals[0] == signal.SIGKILL:
        assert process.returncode == -signal.SIGKILL
    else:  # a second Ctrl-C may meet an interpreter that is closing down; to a shell both are 130
        assert process.returncode in {130, -signal.SIGINT}
    assert run_json("verify", out)["sound"]
    run("collect", out, check=0)
    assert run_json("report", out)["rows"]


def test_ctrl_c_within_the_library_of_files_is_still_ctrl_c(tmp_path, monkeypatch):
    def interrupted_library(*_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            raise StoreError("FastRLock.__exit__ returned a result with an exception set") from None

    monkeypatch.setattr("hydrofdi.api.sweep.write_experiment", interrupted_library)
    with pytest.raises(SweepInterrupted):
        run_sweep(
            load_experiment({"name": "one", "record": {"duration": "2 s"}}), tmp_path, InProcessEngine()
        )


def test_a_second_sweep_on_a_folder_is_refused_with_process_and_host(long_sweep):
    file, out = long_sweep
    process = start("sweep", file, "--out", out)
    try:
        assert wait_until(lambda: (out / "run.log").exists())
        refused = run("sweep", file, "--out", out, check=2)
        assert f"process {process.pid} on {os.uname().nodename}" in refused.stderr
        assert refused.stderr.count("\n") == 1
    finally:
        os.kill(process.pid, signal.SIGTERM)
        process.communicate(timeout=10)


def test_the_lock_of_a_dead_process_is_taken_over_with_a_line(long_sweep):
    file, out = long_sweep
    process = start("sweep", file, "--out", out)
    assert wait_until(lambda: (out / "run.log").exists())
    process.kill()
    process.wait()
    assert nobody_left(process.pid)
    later = run("sweep", file, "--out", out, check=0)
    assert f"took over a stale lock of a sweep that was killed (process {process.pid}" in later.stderr


def test_a_full_disk_gives_one_line_and_loses_nothing(tmp_path):
    file, out = tmp_path / "disk.yaml", tmp_path / "disk"
    file.write_text(
        "name: disk\nrecord: {duration: 2 s}\nsweep:\n  grid:\n"
        "    fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 30]}\n"
    )

    def limit_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    stopped = run("sweep", file, "--out", out, check=2, preexec_fn=limit_files)
    assert [line.partition(": ")[0] for line in stopped.stderr.splitlines()].count("hydrofdi") == 1
    assert "Traceback" not in stopped.stderr
    assert "cannot be written" in stopped.stderr
    assert not list(out.rglob(".*.part"))
    assert run_json("sweep", file, "--out", out)["failed"] == 0
    assert run_json("verify", out)["sound"]


def test_a_folder_that_cannot_be_written_is_reported_in_one_line(tmp_path):
    file, folder = tmp_path / "small.yaml", tmp_path / "closed"
    file.write_text("name: small\nrecord: {duration: 2 s}\nstore: {signals: none}\n")
    run("sweep", file, "--out", folder, check=0)
    (folder / "small.h5").unlink(missing_ok=True)
    for path in [*folder.rglob("*"), folder]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    plain = []
    if os.geteuid() == 0:
        if not shutil.which("setpriv"):
            pytest.skip("root may write everywhere, and there is no setpriv to give that up")
        plain = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]
    refused = subprocess.run(
        [*plain, *COMMAND, "sweep", file, "--out", folder, "--set", "friction.viscous=60"],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert refused.returncode == 2
    assert [line.partition(": ")[0] for line in refused.stderr.splitlines()].count("hydrofdi") == 1
    assert "Traceback" not in refused.stderr
    assert "Permission denied" in refused.stderr


@pytest.mark.parametrize(("n_kill", "n_run"), [(1, 400), pytest.param(3, 2000, marks=pytest.mark.long)])
def test_a_small_torture_keeps_the_bits(tmp_path, n_kill, n_run):
    from runner.torture import torture

    kills = torture(tmp_path, n_kill=n_kill, n_run=n_run, seed=3)
    assert sum(kills.values()) >= n_kill


def test_an_interrupt_at_any_moment_of_feeding_is_met():
    from hydrofdi.execution import LocalPoolEngine

    with LocalPoolEngine(2) as engine:
        for moment in ("_feed", "_busy", "_next_task"):
            for number in range(6):
                engine.submit(abs, -number)
            usual = getattr(engine, moment)

            def interrupted(usual=usual):
                engine.cancel()
                return usual()

            setattr(engine, moment, interrupted)
            assert {result.failure for result in engine.completed()} <= {None}
            setattr(engine, moment, usual)
