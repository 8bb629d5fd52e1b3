"""Samples over MQTT, by a real broker on this machine."""

import json
import subprocess
import time
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

import hydrofdi
from hydrofdi.monitor import topics
from hydrofdi.monitor.configuration import Address, FleetConfig, MonitorConfig, MqttConfig, Pattern
from hydrofdi.monitor.sources import StreamSource
from hydrofdi.monitor.topics import Topics, TopicSource
from hydrofdi.records import Channel
from hydrofdi.records.description import RemarkLimits
from hydrofdi.records.streams import Chunk, EventKind
from tests.commands import COMMAND, run, wait_until
from tests.monitor.brokers import SECRET, client_at
from tests.monitor.streams import Reader, payload_of

P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE
RNG = np.random.default_rng(13)
BLOCKS = [
    Chunk((100 * n + np.arange(100)) / 1000, {P1: RNG.normal(5e6, 1e5, 100), U: RNG.normal(size=100)})
    for n in range(300)
]


class Topic(StreamSource):
    """A topic by itself, over a connection as that of a single machine."""

    def __init__(self, address, config, detector, confirms):
        patterns = [Pattern(address, address.path)]
        fleet = FleetConfig.model_construct(**dict(config))
        self.topics = Topics(patterns, fleet, detector, is_single=True)
        self.source = TopicSource(str(address), config, (), address)
        super().__init__(str(address), self.topics.events)
        self.inbox, self._confirms = self.topics._inbox, confirms

    def read(self, timeout):
        self.topics.dispatch(lambda *_: self.source, timeout or 1e-6)
        chunk = self.source.read(0.0)
        if self._confirms and self.topics.blocking():
            self.confirm()
        return chunk

    def confirm(self):
        self.source.confirm()
        self.topics.acknowledge()

    def close(self):
        self.topics.close()


def source_at(address, config=None, detector=Path("detector.json"), largest=2**20, confirms=True):
    limits = RemarkLimits.model_construct(payload=largest)
    whole = MonitorConfig.model_construct(mqtt=config or MqttConfig(), limits=limits)
    source = Topic(Address.parse(address), whole, detector, confirms)
    super(Topics, source.topics).connect()  # several of one name
    return source


def connected(source):
    return Reader(source).has(EventKind.CONNECTED)


def send(broker, blocks):
    with client_at(broker) as client:
        for sent in [client.publish("press/samples", payload_of(block), 1) for block in blocks]:
            sent.wait_for_publish(30.0)


def times(blocks):
    return np.concatenate([block.time for block in blocks])


def test_the_path_of_a_detector_names_the_monitor_and_the_broker_does_not_see_it(tmp_path, monkeypatch):
    """Those of one file name would throw each other out; a path may be written in any way."""
    monkeypatch.chdir(tmp_path)
    press, short, crane = (
        Topic(
            Address.parse("mqtt://h/t"), MonitorConfig(), Path(folder) / "detector.json", True
        ).topics.client_id
        for folder in (tmp_path / "press", "press", tmp_path / "crane")
    )
    assert press == short != crane
    assert "press" not in press


def test_a_slow_monitor_holds_the_network_up_and_loses_nothing(broker, closing, monkeypatch):
    """However many messages the broker sends at once."""
    monkeypatch.setattr(topics, "CAPACITY", 10 * topics.LEAST_OF_ONE)
    monkeypatch.setattr(topics, "AT_ONCE", 3 * topics.LEAST_OF_ONE)
    source = closing(source_at(broker.address()))
    reader, n_waiting = connected(source), []
    send(broker, BLOCKS)

    def is_there():
        if BLOCKS[-1].time[-1] in reader.times:
            return True
        wait_until(lambda: source.inbox._items)
        n_waiting.append(len(source.inbox._items))
        return False

    reader.until(is_there)
    assert max(n_waiting) == 10
    np.testing.assert_array_equal(reader.times, times(BLOCKS))
    assert len(reader.events) == 1


@pytest.mark.parametrize("confirms", [True, False])
def test_a_broker_that_is_absent_is_waited_for_and_one_that_starts_again_loses_nothing(
    broker, closing, confirms
):
    """Unconfirmed messages are sent again by the broker, also those whose confirmation it did not get."""
    broker.stop()
    source = source_at(broker.address(), confirms=confirms)
    reader, name = Reader(source).has(EventKind.DISCONNECTED), source.topics.client_id
    time.sleep(0.5)  # it tries again, and says nothing
    broker.start()
    reader.has(EventKind.CONNECTED)
    assert [event.kind for event in reader.events] == ["disconnected", "connected"]
    with client_at(broker) as client:
        for block in BLOCKS[:40]:
            if block is BLOCKS[10]:
                reader.has_until(BLOCKS[9].time[-1])
                broker.stop()
            if block is BLOCKS[20]:
                reader.has(EventKind.DISCONNECTED, 2)
                source.confirm()
                broker.start()
            client.publish("press/samples", payload_of(block), 1)
        reader.has_until(BLOCKS[39].time[-1]).has(EventKind.CONNECTED, 2)
    np.testing.assert_array_equal(reader.times, times(BLOCKS[:40]))
    for channel in (P1, U):
        sent = np.concatenate([block.channels[channel] for block in BLOCKS[:40]])
        np.testing.assert_array_equal(reader.channel(channel), sent)
    said = reader.events[2:]
    assert [kind for kind, _ in groupby(event.kind for event in said)] == ["disconnected", "connected"]
    assert len({event.text for event in said}) == len(said)
    source.confirm()
    wait_until(lambda: broker.log.count(f"Received PUBACK from {name}") >= 40)
    source.close()
    reader = connected(closing(source_at(broker.address())))
    send(broker, BLOCKS[40:41])
    np.testing.assert_array_equal(reader.has_until(BLOCKS[40].time[-1]).times, BLOCKS[40].time)


def test_messages_that_are_no_samples_are_counted_and_done_with(broker, closing):
    block, later, old = BLOCKS[:3]
    with client_at(broker) as client:

        def published(payload, retain=False):
            client.publish("press/samples", payload, 1, retain).wait_for_publish(30.0)

        published(payload_of(old), retain=True)  # of long ago: it is not read
        source = source_at(broker.address(), largest=10_000)
        reader = connected(source)
        for payload in (b"no JSON", b"", b"\xff\x00", b'{"time": 1}', b"7" * 20_000, payload_of(block)):
            published(payload)
        reader.has_until(block.time[-1])
        source.confirm()
        np.testing.assert_array_equal(reader.times[np.isfinite(reader.times)], block.time)
        assert sum(len(chunk.unread) for chunk in reader.chunks) == 5
        source.close()
        wait_until(lambda: f"{source.topics.client_id} disconnected" in broker.log)
        reader = Reader(closing(source_at(broker.address(), largest=10_000)))
        published(payload_of(later))
        assert not any(chunk.unread for chunk in reader.has_until(later.time[-1]).chunks)


@contextmanager
def killed(command, **options):
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def windows(log):
    """What a log says of windows, with their instants to the microsecond: those of a replay are made anew."""
    lines = log.read_text().split("\n")[:-1] if log.exists() else []
    records = [record for line in lines if (record := json.loads(line))["line"] == "window"]
    return [each | {key: round(each[key], 6) for key in ("start", "end")} for each in records]


@pytest.mark.long
def test_a_killed_monitor_gives_the_windows_of_the_file_and_shows_no_password(
    machine, guarded, tmp_path, monkeypatch
):
    folder = tmp_path / "life"
    folder.mkdir()
    run("monitor", machine.detector, machine.stream, "--no-follow", "--log", tmp_path / "expected", check=0)
    expected = windows(tmp_path / "expected")
    assert len(expected) == machine.n_window
    monkeypatch.setenv("HYDROFDI_MQTT_USERNAME", "press")
    monkeypatch.setenv("HYDROFDI_MQTT_PASSWORD", SECRET)
    before = source_at(guarded.address(), detector=machine.detector)
    connected(before)
    before.close()
    with client_at(guarded, user="press") as client:
        for chunk in hydrofdi.replay(machine.stream):
            client.publish("press/samples", payload_of(chunk), 1).wait_for_publish(30.0)
    files = ["--state", "state", "--log", "log"]
    command = [*COMMAND, "monitor", str(machine.detector), guarded.address(), *files]
    shown = []
    with (folder / "output").open("ab") as output:
        for number in (5, machine.n_window):
            with killed(command, cwd=folder, stdout=output, stderr=output) as life:
                wait_until(lambda number=number: len(windows(folder / "log")) >= number)
                shown.append(Path(f"/proc/{life.pid}/cmdline").read_bytes())
    assert windows(folder / "log") == expected
    shown += [file.read_bytes() for file in folder.iterdir()] + [guarded.log.encode()]
    assert len(shown) >= 6
    assert not [text for text in shown if SECRET.encode() in text]
