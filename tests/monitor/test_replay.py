"""``hydrofdi replay``: records as a stream, to the bit, at a steady rate, into pipes and a broker."""

import signal
import subprocess
import time

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


@pytest.mark.parametrize(("form", "first"), [("csv", 0), ("json", 1)])
def test_samples_are_read_again_to_the_bit_and_records_follow_with_a_gap(experiment, form, first):
    options = ["--record", "2"] if first else []
    done = run("replay", experiment, "--format", form, *options, "--rate", "max", check=0)
    chunk, unread = read_in_pieces(reader(), done.stdout.encode(), range(10_000, len(done.stdout), 9_999))
    assert unread == []
    (source,) = open_records(experiment, said=Described())
    (batch,) = source.batches()
    assert set(chunk.channels) == set(batch.channels)
    for channel, samples in batch.channels.items():
        assert np.array_equal(chunk.channels[channel], samples[first:].ravel(), equal_nan=True), channel
    n_time = batch.time.size
    assert np.array_equal(chunk.time[:n_time], batch.time)
    assert done.stderr.splitlines()[1:] == [f"played {chunk.n_time:,} samples"]
    if not first:
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


@pytest.mark.parametrize(("arguments", "said"), [
    (["--rate", "0Hz"], "rate"), (["--to", "file.csv"], "to file.csv"), (["--record", "7"], "'7'"),
    (["--to", "mqtt://127.0.0.1:1/x", "--format", "csv"], "format"),
    (["--to", "mqtts://127.0.0.1:1/x", "--config", "absent.yaml"], "absent.yaml"),
    (["--set", "fluid.nothing=1"], "fluid.nothing"),
])  # fmt: skip
def test_what_can_be_fixed_is_said_in_a_line(experiment, arguments, said):
    done = run("replay", experiment, *arguments, check=2)
    assert said in done.stderr
    assert len([line for line in done.stderr.splitlines() if "simulating" not in line]) == 1
    assert done.stdout == ""


def test_an_interrupt_and_a_reader_that_leaves_end_it(experiment):
    for is_left in (True, False):
        command = [*COMMAND, "replay", str(experiment), "--rate", "max" if is_left else "1Hz"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        with subprocess.Popen(command, text=True, **pipes) as process:
            try:
                assert process.stdout.readline().startswith("time [s],P1 [Pa]")
                if is_left:
                    process.stdout.close()
                else:
                    process.send_signal(signal.SIGINT)
                assert process.wait(60) == 0
                assert is_left or process.stderr.read().splitlines()[-1].startswith("stopped after ")
            finally:
                process.kill()
