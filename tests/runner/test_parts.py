"""Parts of a sweep: plain jobs that share a folder."""

import json
import os
import signal

import pytest

import hydrofdi
from hydrofdi.config.loading import load_experiment
from hydrofdi.engine import InProcessEngine
from hydrofdi.errors import ConfigError, StoreError
from hydrofdi.execution.plan import SweepPart, plan_sweep
from hydrofdi.execution.sweeping import run_sweep
from hydrofdi.store.folder import Failure, experiment_lock, read_failures, read_provenance, write_failure
from tests.commands import run, run_json
from tests.runner.processes import shards, start, wait_until

SMALL = {
    "name": "small",
    "record": {"duration": "2 s"},
    "store": {"signals": "none"},
    "sweep": {"grid": {"fluid.bulk_modulus": {"linspace": ["551 MPa", "827 MPa", 80]}}},
}


def test_parts_have_every_run_once_whatever_is_stored():
    for n_run, of in ((0, 2), (31, 3), (450, 7), (5000, 64)):
        parts = [SweepPart(number, of).positions(n_run) for number in range(1, of + 1)]
        assert sorted(position for part in parts for position in part) == [*range(n_run)]


def test_parts_at_the_same_time_one_of_them_killed_give_the_bytes_of_one_sweep(long, tmp_path):
    (file, whole), out = long, tmp_path / "out"
    part = ("sweep", file, "--out", out, "--workers", "1", "--part")
    first, second = start(*part, "1/2"), start(*part, "2/2")
    try:
        log = out / "run-2-of-2.log"
        wait_until(lambda: log.exists() and '"stored"' in log.read_text())
        os.killpg(second.pid, signal.SIGKILL)
        second.communicate()
        assert run_json("status", out)["planned"] == 600
        _, told = first.communicate(timeout=120)
    finally:
        for process in (first, second):
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.communicate()
    assert (first.returncode, "stored part 1/2" in told) == (0, True), told
    again = run_json(*part, "2/2")
    assert again["skipped"] > 0 < again["completed"]
    assert again["skipped"] + again["completed"] == again["planned"] == len(SweepPart(2, 2).positions(600))
    assert not (out / "long.h5").exists()
    run("collect", out, check=0)
    assert (out / "long.h5").read_bytes() == whole
    assert run_json("sweep", file, "--out", out)["completed"] == 0
    assert [record["command"][-1] for record in read_provenance(out)] == ["1/2", "--json"]


@pytest.fixture
def out(tmp_path):
    """The folder of a sweep whose first part of two is stored."""
    hydrofdi.sweep(SMALL, out=tmp_path, engine="in-process", part="1/2")
    return tmp_path


def refused(**options):
    with pytest.raises(StoreError, match="another sweep is at work there"):
        hydrofdi.sweep(SMALL, engine="in-process", **options)


def test_parts_keep_whole_sweeps_and_themselves_away_but_no_other_part(out):
    with experiment_lock(out, print, "-2-of-2"):
        refused(out=out)
        refused(out=out, part="2/2", retry_failed=True)
        with pytest.raises(StoreError):
            hydrofdi.collect(out)
        assert hydrofdi.sweep(SMALL, out=out, engine="in-process", part="2/3").summary.completed == 32
    with experiment_lock(out, print):
        refused(out=out, part="2/2")
    assert hydrofdi.collect(out).statuses == {"ok": 80}


def test_a_part_touches_nothing_of_the_others(out):
    plan, experiment = plan_sweep(load_experiment(SMALL), out), load_experiment(SMALL)
    leftover, damaged = out / "shards" / ".new.h5.1.part", shards(out)[0]
    leftover.touch()
    damaged.write_bytes(b"")
    failed = {plan.run_ids[position] for position in (0, 40)}
    for run_id in failed:
        write_failure(out, Failure(run_id, "error", "as if"))
    summary = run_sweep(experiment, out, InProcessEngine(), retry_failed=True, part=SweepPart(2, 2))
    assert (summary.planned, summary.completed, summary.stored) == (32, 32, 32)
    assert read_failures(out).keys() == {plan.run_ids[0]}
    assert leftover.exists()
    assert damaged.exists()
    assert json.loads((out / "run-2-of-2.log").read_text().splitlines()[-1])["completed"] == 32
    hydrofdi.collect(out)
    assert not [*out.rglob(".*.part"), *out.glob(".part*")]


@pytest.mark.parametrize("part", ["0/64", "65/64", "a/b", "3", "-1/2", "1/0", 3, ""])
def test_a_part_that_is_none_is_refused(tmp_path, part):
    with pytest.raises(ConfigError, match=r"^part: "):
        hydrofdi.sweep(SMALL, out=tmp_path / "out", engine="in-process", part=part)
    assert not (tmp_path / "out").exists()
