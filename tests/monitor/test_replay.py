"""``hydrofdi replay``: records as a stream, to the bit, at a steady rate, into pipes and a broker."""

import os
import signal
import subprocess
import time
from contextlib import contextmanager

import numpy as np
import pytest

from hydrofdi.api.sources import Described, open_records
from hydrofdi.api.streams import replay
from tests.commands import COMMAND, run
from tests.monitor.streams import read_in_pieces, reader

EXPERIMENT = "record: {duration: 4 s}\nsweep: {grid: {leakage.internal_flow: [0 L/min, 0.5 L/min]}}\n"


@pytest.fixture
def experiment(tmp_path):
    file = tmp_path / "press.yaml"
    file.write_text(EXPERIMENT, encoding="utf-8")
    return file


def replayed(*arguments):
    done = run("replay", *arguments, "--rate", "max", check=0)
    chunk, events = read_in_pieces(reader(), done.stdout.encode(), range(10_000, len(done.stdout), 9_999))
    assert events == []
    return chunk, done


def records(file, settings=()):
    return [
        (batch.time, {channel: samples[row] for channel, samples in batch.channels.items()})
        for batch in open_records(file, said=Described(settings=settings))[0].batches()
        for row in range(batch.n_record)
    ]


@pytest.mark.parametrize(("form", "record"), [("csv", None), ("json", "2")])
def test_samples_are_read_again_to_the_bit_and_records_follow_with_a_gap(experiment, form, record):
    chunk, done = replayed(experiment, "--format", form, *(["--record", record] if record else []))
    made = records(experiment)
    (times, _), n_time = made[0], made[0][0].size
    for row, (_, channels) in enumerate(made[1:] if record else made):
        for channel, samples in channels.items():
            found = chunk.channels[channel][row * n_time : (row + 1) * n_time]
            assert np.array_equal(found, samples, equal_nan=True), channel
    assert np.array_equal(chunk.time[:n_time], times)
    assert set(chunk.channels) == set(channels)
    assert done.stderr.splitlines()[1:] == [f"played {chunk.n_time:,} samples"]
    if record is None:
        steps = np.diff(chunk.time)
        assert steps.argmax() == n_time - 1
        assert steps.max() == pytest.approx(10 * steps.min())


def test_nothing_comes_before_it_is_due_and_stamps_of_now_are_even_to_the_bit(experiment, monkeypatch):
    begin = time.monotonic()
    for chunk in replay(np.zeros(60), rate=1000.0, sampling_frequency=10.0):
        assert time.monotonic() - begin >= 0.1 * chunk.time[-1] / 10.0 - 1e-3
    start = 1_700_000_000.3
    monkeypatch.setattr(time, "time", lambda: start)
    blocks = [*replay(experiment, record="1", now=True, settings=["record.duration=1 s"])]
    stamps = np.concatenate([block.time for block in blocks])
    assert np.array_equal(stamps, start + np.arange(stamps.size) / 500.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--rate", "0Hz"], "rate"),
        (["--to", "file.csv"], "to file.csv"),
        (["--to", "mqtt://127.0.0.1:1/x", "--format", "csv"], "format"),
        (["--to", "mqtts://127.0.0.1:1/x", "--config", "absent.yaml"], "absent.yaml"),
        (["--record", "7"], "'7'"),
        (["--set", "fluid.nothing=1"], "fluid.nothing"),
    ],
)
def test_what_can_be_fixed_is_said_in_a_line(experiment, arguments, said):
    done = run("replay", experiment, *arguments, check=2)
    assert said in done.stderr
    assert len([line for line in done.stderr.splitlines() if "simulating" not in line]) == 1
    assert done.stdout == ""


@contextmanager
def started(*arguments):
    process = subprocess.Popen(
        [*COMMAND, "replay", *map(str, arguments)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def test_an_interrupt_and_a_reader_that_leaves_end_it(experiment):
    with started(experiment, "--rate", "max") as process:
        assert process.stdout.readline().startswith("time [s],P1 [Pa]")
        process.stdout.close()
        assert process.wait(60) == 0
        process.stderr.close()
    with started(experiment, "--rate", "1Hz") as process:
        assert process.stdout.readline().startswith("time [s],P1 [Pa]")
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors.splitlines()[-1].split(" after ")[0]) == (0, "stopped")
