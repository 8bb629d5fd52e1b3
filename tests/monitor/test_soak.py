"""A stream that grows while its monitor is killed at random moments: each thing is said once."""

import json
import random
import sqlite3
import subprocess
import time
from contextlib import closing, suppress

import numpy as np
import pytest

from tests.commands import COMMAND, run, wait_until
from tests.monitor.streams import logged
from tests.records.measuring import csv_of

FREQUENCY = 500


def stream(machine, n_minute, chance):
    """Text with time [s] and P1 [bar]: a leak after two thirds, and all that goes wrong on the way."""
    draw = np.random.default_rng(0)
    n_sample = 60 * n_minute * FREQUENCY
    time, pressure = np.loadtxt(machine.stream, delimiter=",", skiprows=1, unpack=True)
    healthy, leaking = (
        np.resize(pressure[part], n_sample) for part in (time < machine.onset, time >= machine.onset)
    )
    samples = np.where(np.arange(n_sample) < 2 * n_sample // 3, healthy, leaking)
    rows = np.column_stack([np.arange(n_sample) / FREQUENCY, samples])
    for _ in range(4 * n_minute):
        at, n = draw.integers(len(rows)), draw.integers(1, 1000)
        kind = draw.choice(["lost", "twice", "late", "missing", "stuck"])
        if kind == "lost":
            rows = np.delete(rows, slice(at, at + n), axis=0)
        elif kind == "twice":
            rows = np.insert(rows, at, rows[at], axis=0)
        elif kind == "late":
            rows = np.insert(rows, at, rows[max(0, at - n) : at], axis=0)
        else:
            rows[at : at + 5 * n, 1] = np.nan if kind == "missing" else 90.0
    instants, samples = rows.T
    lines = csv_of(("time [s]", instants), ("P1 [bar]", samples)).splitlines(keepends=True)
    for _ in range(2 * n_minute):
        lines.insert(chance.randrange(2, len(lines)), "no row\n")
    return "".join(lines)


def has_stored(state):
    address = f"file:{state}?mode=ro"
    with suppress(sqlite3.OperationalError), closing(sqlite3.connect(address, uri=True)) as file:
        return file.execute("select count(*) from machine").fetchone()[0]


def write_slowly(file, content, duration):
    n_part = max(1, round(duration / 0.02))
    for part in range(n_part):
        file.write(content[part * len(content) // n_part : (part + 1) * len(content) // n_part])
        time.sleep(0.02)


@pytest.mark.parametrize(
    ("n_minute", "n_kill"), [(5, 5), pytest.param(60, 50, marks=pytest.mark.long)], ids=["short", "an hour"]
)
def test_killed_at_random_moments_it_says_what_the_undisturbed_one_says(machine, n_minute, n_kill, tmp_path):
    chance = random.Random(0)
    whole, growing, output = tmp_path / "whole.csv", tmp_path / "growing.csv", tmp_path / "out"
    whole.write_text(stream(machine, n_minute, chance))
    run("monitor", machine.detector, whole, "--no-follow", "--log", tmp_path / "undisturbed", check=0)
    files = ["--state", tmp_path / "state", "--log", tmp_path / "log"]
    command = [*COMMAND, "monitor", machine.detector, growing, *files]
    content = whole.read_bytes()
    bounds = sorted(chance.sample(range(len(content)), 2 * n_kill))
    errors = tmp_path / "errors"
    with open(errors, "ab") as err, open(growing, "ab", buffering=0) as file, output.open("ab", 0) as out:
        for life, (first, stop) in enumerate(zip(bounds[::2], bounds[1::2], strict=True)):
            file.write(content[bounds[2 * life - 1] if life else 0 : first])
            with subprocess.Popen(command, stdout=out, stderr=err) as process:
                if chance.random() < 0.9:
                    n_byte = output.stat().st_size
                    wait_until(lambda n=n_byte: output.stat().st_size > n, process)
                    write_slowly(file, content[first:stop], chance.uniform(0.0, 0.4))
                else:
                    time.sleep(chance.uniform(0.0, 0.4))
                    file.write(content[first:stop])
                if not life:  # all others take up a state
                    wait_until(lambda: has_stored(tmp_path / "state"), process)
                assert process.poll() is None, errors.read_text()
                process.kill()
            out.write(b"\n")
        file.write(content[bounds[-1] :])
        subprocess.run([*command, "--no-follow"], stdout=out, check=True, timeout=600)
    records = logged(tmp_path / "log")
    assert records == logged(tmp_path / "undisturbed")
    said = {*output.read_text().splitlines()}  # the last line of a life may be torn
    assert {json.dumps(record, ensure_ascii=False) for record in records} <= said
    assert output.read_text().count('"resumed"') >= n_kill // 2
    numbers = [record["number"] for record in records if record["line"] == "window"]
    assert numbers == list(range(len(numbers)))
    expected = "alarm_raised", "gap", "duplicate", "time_ran_back", "stuck", "missing_samples", "malformed"
    assert {*expected} <= {record.get("event") for record in records}
