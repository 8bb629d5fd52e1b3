"""A monitor of a stream over MQTT: its windows are those of the undisturbed stream, whatever breaks."""

import json
import random
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path

import pytest

from hydrofdi.monitor.mqtt import source as mqtt_source
from tests.commands import COMMAND
from tests.commands import run as run_command
from tests.monitor.brokers import SECRET, needs_mosquitto
from tests.monitor.machines import make_machine
from tests.monitor.mqtt_streams import connected, killed, publisher_at, source_at, wait_for
from tests.monitor.streams import (
    N_SAMPLE,
    Killed,
    KilledAt,
    Samples,
    live,
    logged,
    made_detector,
    part,
    stream,
)

pytestmark = needs_mosquitto

N_WINDOW, N_BLOCK = 40, 100
FILE = made_detector()
MADE = stream(N_WINDOW, leaking=[12, 13, 30], stuck=[20, 21])
BLOCKS = [part(MADE, first, first + N_BLOCK) for first in range(0, N_WINDOW * N_SAMPLE, N_BLOCK)]

CONCERNS_CONNECTIONS = {"started", "resumed", "stopped", "connected", "disconnected"}


def run(folder, source, sinks=(), stop=lambda: False):
    live(folder, source, sinks, stop, FILE)


def of_samples(folder):
    return logged(folder, CONCERNS_CONNECTIONS)


def is_complete(folder):
    """Asks whether all windows are there; not for ever."""
    end = time.monotonic() + 60.0

    def ask():
        assert time.monotonic() < end, f"{n_logged(folder)} windows"
        return n_logged(folder) == N_WINDOW

    return ask


def n_logged(folder):
    """Whole lines about windows."""
    log = folder / "log.jsonl"
    return log.read_text().count('"window"') if log.exists() else 0


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    run(folder, Samples(MADE))
    return of_samples(folder)


@pytest.fixture
def subscribed(broker):
    """The broker knows the monitor, and keeps messages for it."""
    source = source_at(broker.address())
    connected(source)
    source.close()
    return broker


def send(broker, blocks):
    publisher = publisher_at(broker.address())
    try:
        for block in blocks:
            while not publisher.send(block):
                pass
        assert publisher.flush(60.0)
    finally:
        publisher.close()


def source_of(broker):
    """A source that the monitor opens."""
    return source_at(broker.address(), is_open=False)


def test_killed_again_and_again_no_window_is_lost_or_twice(subscribed, undisturbed, tmp_path, monkeypatch):
    monkeypatch.setattr(mqtt_source, "AT_ONCE", 4 * mqtt_source.LEAST_SIZE)
    draw = random.Random(5)
    with ThreadPoolExecutor(1) as pool:
        sending = pool.submit(send, subscribed, BLOCKS)
        for life in count():
            try:
                sinks = [KilledAt(draw.randint(1, 7))] if life < 12 else []
                run(tmp_path, source_of(subscribed), sinks, is_complete(tmp_path))
                break
            except Killed:
                continue
        sending.result()
    assert life == 12
    assert of_samples(tmp_path) == undisturbed


def test_a_broker_that_starts_again_in_mid_stream_changes_no_window(subscribed, undisturbed, tmp_path):
    def restart():
        for number in (8, 20):
            wait_for(lambda number=number: n_logged(tmp_path) >= number)
            subscribed.stop()
            subscribed.start()

    with ThreadPoolExecutor(2) as pool:
        others = pool.submit(send, subscribed, BLOCKS), pool.submit(restart)
        run(tmp_path, source_of(subscribed), stop=is_complete(tmp_path))
        for other in others:
            other.result()
    assert _windows(of_samples(tmp_path)) == _windows(undisturbed)


def _windows(lines):
    """Without what a sender repeats because the broker's answer was lost: such samples are dropped."""
    return [line for line in lines if line.get("event") not in ("time_ran_back", "duplicate")]


LIFE = """
import sys
from pathlib import Path
from tests.monitor.mqtt_streams import source_at
from tests.monitor.test_mqtt_monitor import run
run(Path(sys.argv[2]), source_at(sys.argv[1], is_open=False))
"""


@pytest.mark.long
def test_sigkill_and_broken_brokers_change_no_window(subscribed, undisturbed, tmp_path):
    with ThreadPoolExecutor(1) as pool:
        sending = pool.submit(send, subscribed, BLOCKS)
        for number in (3, 9, 15, 22, 31, N_WINDOW):
            command = [sys.executable, "-c", LIFE, subscribed.address(), str(tmp_path)]
            with killed(command):
                wait_for(lambda number=number: n_logged(tmp_path) >= number, timeout=120.0)
            if number in (9, 22):
                subscribed.stop()
                subscribed.start()
        sending.result()
    assert of_samples(tmp_path) == undisturbed


def windows(log):
    """What a log says of windows, with their instants to the microsecond: those of a replay are made anew."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    records = [record for line in lines if (record := json.loads(line))["line"] == "window"]
    return [each | {key: round(each[key], 6) for key in ("start", "end")} for each in records]


@pytest.mark.long
def test_a_killed_monitor_gives_the_windows_of_the_file_and_shows_no_password(guarded, tmp_path, monkeypatch):
    machine, folder = make_machine(tmp_path), tmp_path / "life"
    folder.mkdir()
    run_command(
        "monitor", machine.detector, machine.stream, "--no-follow", "--log", tmp_path / "expected", check=0
    )
    expected = windows(tmp_path / "expected")
    assert len(expected) == machine.n_window
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    before = source_at(guarded.address(), detector=machine.detector)
    connected(before)
    before.close()
    run_command("replay", machine.stream, "--rate", "max", "--to", guarded.address(), check=0)
    files = ["--state", "state", "--log", "log", "--events", guarded.address("press/events")]
    command = [*COMMAND, "monitor", str(machine.detector), guarded.address(), *files]
    arguments = []
    with (folder / "output").open("ab") as output:
        for number in (5, machine.n_window):
            with killed(command, cwd=folder, stdout=output, stderr=output) as life:
                wait_for(lambda number=number: len(windows(folder / "log")) >= number, timeout=120.0)
                arguments.append(Path(f"/proc/{life.pid}/cmdline").read_text())
    assert windows(folder / "log") == expected
    shown = [file.read_bytes() for file in folder.iterdir()] + [guarded.log.encode()]
    assert len(shown) >= 4
    assert not [text for text in shown if SECRET.encode() in text]
    assert SECRET not in "".join(arguments)
