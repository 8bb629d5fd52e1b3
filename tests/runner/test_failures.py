"""Runs that raise, hang, or lose their worker; sweeps that are stopped; disks that are full."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import pytest

from hydrofdi.config.loading import load_experiment
from hydrofdi.engine import InProcessEngine, LocalPoolEngine, TaskFailure, _without_interrupts
from hydrofdi.errors import StoreError, SweepInterrupted
from hydrofdi.execution.plan import plan_sweep
from hydrofdi.execution.sweeping import run_sweep
from tests.commands import COMMAND, run, run_json
from tests.runner.processes import computing, kill, nobody_left, says, shards, start, wait_until, workers

BAD_RUNS = """\
name: bad
record: {duration: 2 s, sampling_frequency: 10 kHz}
limits: {time_per_job: 12 s}
store: {signals: none}
sweep:
  union:
    - grid: {fluid.bulk_modulus: [551 MPa, 600 MPa, 689 MPa, 827 MPa]}
    - grid: {record.duration: [1000 s]}     # raises, where memory is limited
    - grid: {record.step: [1.0e-9 s]}       # hangs for all practical purposes
"""


def limited(kind, size):
    """Options of a process with a limit on what it may use."""
    return {"preexec_fn": lambda: resource.setrlimit(kind, (size, size))}


@pytest.fixture(scope="module")
def memory():
    """Enough for ordinary runs, but not for a record of ten million samples [bytes]."""
    code = (
        "from hydrofdi.config import RunParameters; from hydrofdi.execution.compute import *;"
        "compute_columns([Job('', RunParameters(), 0.0)]);"
        "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmPeak')))"
    )
    usual = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout
    return 1024 * int(usual) + 250_000_000


def test_runs_that_raise_or_hang_become_rows_and_the_others_finish(tmp_path, memory):
    file, out = tmp_path / "bad.yaml", tmp_path / "bad"
    file.write_text(BAD_RUNS)
    summary = run_json("sweep", file, "--out", out, check=1, **limited(resource.RLIMIT_AS, memory))
    assert (summary["planned"], summary["failed"], summary["lost_workers"]) == (6, 2, 0)
    assert run_json("status", out, check=1)["statuses"] == {"ok": 4, "error": 1, "timeout": 1}
    rows = {row["status"]: row for row in run_json("report", out)["rows"]}
    assert "MemoryError" in rows["error"]["message"]
    assert "12 s" in rows["timeout"]["message"]
    assert "Traceback" in run_json("why", out, "4")["log"]
    again = run_json("sweep", file, "--out", out, check=1)
    assert (again["completed"], again["failed"]) == (0, 2)
    assert len(plan_sweep(load_experiment(file), out, retry_failed=True).missing) == 2


def test_a_run_whose_worker_is_killed_becomes_a_row_and_can_be_tried_again(tmp_path):
    file, out = tmp_path / "one.yaml", tmp_path / "one"
    file.write_text("name: one\nrecord: {duration: 5 s, step: 1.0e-6 s}\nstore: {signals: none}\n")
    process = start("sweep", file, "--out", out, "--workers", "1")
    kill(wait_until(lambda: computing(process.pid))[0])
    process.communicate(timeout=60)
    assert process.returncode == 1
    (failure,) = [row for row in run_json("report", out)["rows"] if row["status"] != "ok"]
    assert failure["status"] == "killed"
    retried = run_json("sweep", file, "--out", out, "--retry-failed", "--engine", "in-process")
    assert (retried["completed"], retried["failed"]) == (1, 0)


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
    """Loses what solves K_i of 0.3 L/min, as if its worker were killed there."""

    def completed(self):
        for result in super().completed():
            group = result.item if isinstance(result.item, tuple) else ()
            if any(abs(condition.leakage.internal_flow - 5e-6) < 1e-9 for _, condition in group):
                result = replace(result, value=None, failure=TaskFailure("killed", "lost"))
            yield result


def test_what_is_lost_while_leaks_are_solved_becomes_a_row_and_can_be_tried_again(tmp_path):
    file, out = tmp_path / "flows.yaml", tmp_path / "flows"
    file.write_text(FLOWS)
    summary = run_sweep(load_experiment(file), out, Losing())
    assert (summary.statuses, summary.failed, summary.stored) == ({"killed": 1}, 1, 6)
    retried = run_json("sweep", file, "--out", out, "--retry-failed", "--engine", "in-process")
    assert retried["statuses"] == {}


@pytest.mark.parametrize(("stops", "codes"), [
    ([signal.SIGINT], {130}),
    # a second Ctrl-C may meet an interpreter that is closing down; to a shell both are 130
    pytest.param([signal.SIGINT, signal.SIGINT], {130, -signal.SIGINT}, marks=pytest.mark.long),
    ([signal.SIGTERM], {130}),
    pytest.param([signal.SIGKILL], {-signal.SIGKILL}, marks=pytest.mark.long),
    ([], {0}),
], ids=["Ctrl-C", "Ctrl-C twice", "SIGTERM", "SIGKILL", "a worker is killed"])  # fmt: skip
def test_a_stop_leaves_no_process_and_the_sweep_goes_on_to_the_same_bits(long, tmp_path, stops, codes):
    (file, whole), out = long, tmp_path / "long"
    process = start("sweep", file, "--out", out)
    wait_until(lambda: shards(out))
    if not stops:
        kill(workers(process.pid)[0])
    for position, number in enumerate(stops):
        assert position == 0 or says(process, "press Ctrl-C again")
        os.kill(process.pid, number)
    _, told = process.communicate(timeout=60)
    assert process.returncode in codes
    assert "Traceback" not in told
    assert (", 1 worker lost and replaced\n" in told) == (not stops)
    last = json.loads((out / "run.log").read_text().splitlines()[-1])
    assert last.get("lost_workers", 0) == (not stops)
    assert nobody_left(process.pid)
    assert run_json("verify", out)["sound"]
    if signal.SIGKILL not in stops:  # whose lock is left
        run("collect", out, check=0)
    status = run_json("status", out)
    assert (0 < status["done"] < status["planned"]) == bool(stops)
    if stops == [signal.SIGINT]:
        assert f"runs stored: {status['done']:,} of 600; the same command continues from there" in told
    later = run("sweep", file, "--out", out, "--json", check=0)
    assert json.loads(later.stdout)["completed"] == status["missing"]
    took_over = f"took over a stale lock of a sweep that was killed (process {process.pid}"
    assert (took_over in later.stderr) == (stops == [signal.SIGKILL])
    assert (out / "long.h5").read_bytes() == whole


SLOW = """\
name: slow
record: {duration: 400 s, sampling_frequency: 2 kHz, step: 0.01 ms}
store: {signals: none}
sweep: {grid: {fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 200]}}}
"""


@pytest.fixture
def slow(tmp_path):
    """A sweep whose first run never ends, in a session of its own."""
    (tmp_path / "slow.yaml").write_text(SLOW)
    process = start("sweep", "slow.yaml", "--out", "out", cwd=tmp_path)
    yield process
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


@pytest.mark.parametrize("when", ["runs to compute", "first run"])
@pytest.mark.parametrize("send", [os.kill, os.killpg], ids=["the command alone", "as a terminal does"])
def test_an_interrupt_before_the_first_run_says_that_nothing_was_stored(slow, tmp_path, send, when):
    """Also while the fork server starts."""
    if when == "first run":
        wait_until((tmp_path / "out" / "run.log").exists)
        refused = run("sweep", "slow.yaml", "--out", "out", check=2, cwd=tmp_path)
        assert f"process {slow.pid} on {os.uname().nodename}" in refused.stderr
        assert refused.stderr.count("\n") == 1
    else:
        assert says(slow, when)
    send(slow.pid, signal.SIGINT)
    if says(slow, "press Ctrl-C again"):
        send(slow.pid, signal.SIGINT)
    _, told = slow.communicate(timeout=60)
    assert slow.returncode == 130
    assert "Traceback" not in told
    assert when != "first run" or "interrupted before the first run ended; nothing was stored\n" in told


def test_ctrl_c_is_held_back_while_a_worker_starts_though_other_threads_take_it():
    ended, started = threading.Event(), []
    threading.Thread(target=ended.wait).start()

    def begun():
        with _without_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.2)
            started.append(True)

    try:
        with pytest.raises(KeyboardInterrupt):
            begun()
    finally:
        ended.set()
    assert started


def test_an_interrupt_at_any_moment_of_feeding_is_met():
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


def test_ctrl_c_within_the_library_of_files_is_still_ctrl_c(tmp_path, monkeypatch):
    def interrupted_library(*_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            raise StoreError("FastRLock.__exit__ returned a result with an exception set") from None

    monkeypatch.setattr("hydrofdi.execution.sweeping.write_experiment", interrupted_library)
    experiment = load_experiment({"name": "one", "record": {"duration": "2 s"}})
    with pytest.raises(SweepInterrupted):
        run_sweep(experiment, tmp_path, InProcessEngine())


def assert_one_line(refused, words):
    assert [line.partition(": ")[0] for line in refused.stderr.splitlines()].count("hydrofdi") == 1
    assert "Traceback" not in refused.stderr
    assert words in refused.stderr


@pytest.mark.parametrize("size", [10, 200_000], ids=["at the start", "in the middle"])
def test_a_full_disk_gives_one_line_and_loses_nothing(tmp_path, size):
    file, out = tmp_path / "disk.yaml", tmp_path / "disk"
    moduli = "{fluid.bulk_modulus: {linspace: [551 MPa, 827 MPa, 30]}}"
    file.write_text(f"name: disk\nrecord: {{duration: 2 s}}\nsweep: {{grid: {moduli}}}\n")
    stopped = run("sweep", file, "--out", out, check=2, **limited(resource.RLIMIT_FSIZE, size))
    assert_one_line(stopped, "cannot be written")
    assert not list(out.rglob(".*.part"))
    assert run_json("sweep", file, "--out", out, "--engine", "in-process")["failed"] == 0
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
            pytest.skip("root may write everywhere without setpriv: apt install util-linux")
        plain = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"]
    refused = subprocess.run(
        [*plain, *COMMAND, "sweep", file, "--out", folder, "--set", "friction.viscous=60"],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert refused.returncode == 2
    assert_one_line(refused, "Permission denied")


@pytest.mark.long
def test_kills_at_random_moments_keep_the_bits(tmp_path):
    from tests.runner.torture import torture

    kills = torture(tmp_path, n_kill=3, n_run=1000, seed=3)
    assert sum(kills.values()) >= 3
