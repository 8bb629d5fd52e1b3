"""Samples over MQTT, by a real broker on this machine."""

import json
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

import hydrofdi
from hydrofdi.detectors.lines import Condition, WindowLine, line_record
from hydrofdi.detectors.verdicts import Verdict
from hydrofdi.monitor import topics
from hydrofdi.monitor.configuration import Address, FleetConfig, MonitorConfig, MqttConfig, Pattern
from hydrofdi.monitor.mqtt import MqttSink, Publisher
from hydrofdi.monitor.sources import StreamSource
from hydrofdi.monitor.topics import Topics, TopicSource
from hydrofdi.records import Channel
from hydrofdi.records.description import RemarkLimits
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.commands import COMMAND, run, wait_until
from tests.monitor.brokers import SECRET, Broker, client_at
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
    source.topics.connect()
    return source


def connected(source):
    return Reader(source).has(EventKind.CONNECTED)


def send(broker, blocks):
    publisher = Publisher(Address.parse(broker.address()), MqttConfig(), 1000)
    for block in blocks:
        assert publisher.wait_until(19, 30.0)
        assert publisher.send(payload_of(block))
    assert publisher.wait_until(0, 30.0)
    publisher.close()


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
    publisher = closing(Publisher(Address.parse(broker.address()), MqttConfig(), 1000))
    for block in BLOCKS[:40]:
        if block is BLOCKS[10]:
            reader.has_until(BLOCKS[9].time[-1])
            broker.stop()
        if block is BLOCKS[20]:
            reader.has(EventKind.DISCONNECTED, 2)
            source.confirm()
            broker.start()
        assert publisher.send(payload_of(block))
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


LINES = "press/lines"
ALARM = Event(EventKind.ALARM_RAISED, "the score 3.2 bar is above 2.1 bar", 12.5)
WINDOW = WindowLine(7, 10.0, 12.0, Verdict(score=1.5, alarm=False, margin=0.4), None, Condition.HEALTHY)


class Listener:
    """What is published under a topic, retained messages included."""

    def __init__(self, broker, client_id=""):
        self.messages, self._stack = [], ExitStack()
        client = self._stack.enter_context(client_at(broker, client_id))
        client.on_message = lambda _, __, message: self.messages.append(message)
        client.on_subscribe = lambda *_: self.messages.append(None)
        client.subscribe(f"{LINES}/#", qos=1)
        wait_until(lambda: None in self.messages)
        self.close = self._stack.close

    def payloads(self, topic=LINES):
        return [each.payload for each in self.messages if each and each.topic == topic]

    @property
    def states(self):
        return self.payloads(f"{LINES}/status")


def sink_at(broker, with_windows=False, **options):
    return MqttSink(Address.parse(broker.address(LINES)), MqttConfig(windows=with_windows), **options)


def said_by(sink, lines):
    """Send lines that it wants; what happened to those before."""
    return sink.send_all([json.dumps(line_record(line)) for line in lines if sink.wants(line)])


def wait_for(sink, kind):
    wait_until(lambda: kind in [each.kind for each in said_by(sink, [])])


def test_events_are_sent_and_windows_on_request(broker, closing):
    listener = closing(Listener(broker))
    for with_windows, expected in ((False, ["event"]), (True, ["window", "event"])):
        listener.messages.clear()
        sink = sink_at(broker, with_windows)
        said_by(sink, [WINDOW, ALARM, replace(ALARM, is_silent=True)])
        sink.close()
        wait_until(lambda: listener.states[-1:] == [b"offline"])
        records = [json.loads(payload) for payload in listener.payloads()]
        assert [record["line"] for record in records] == expected
        assert records[-1]["text"] == ALARM.text


def test_lines_come_in_order_over_a_broker_that_starts_again_and_those_too_many_are_counted(broker, closing):
    sink, listener = closing(sink_at(broker, capacity=50)), closing(Listener(broker, client_id="listener"))
    wait_for(sink, EventKind.CONNECTED)
    events, said = [replace(ALARM, time=float(number)) for number in range(120)], []
    for number, event in enumerate(events):
        if number == 20:
            assert sink.wait_until(0, 30.0)
            broker.stop()
            wait_for(sink, EventKind.DISCONNECTED)
        said += said_by(sink, [event])
    dropped = [line for line in said if line.kind is EventKind.DROPPED]
    assert sum(line.count for line in dropped) == 50
    assert [line.is_silent for line in dropped] == [False] + [True] * 49
    broker.start()
    wait_for(sink, EventKind.CONNECTED)
    for sent_now in ([], [replace(ALARM, time=500.0)]):
        assert not [line for line in said_by(sink, sent_now) if line.kind is EventKind.DROPPED]
        assert sink.wait_until(0, 30.0)

    def instants():
        return list(dict.fromkeys(json.loads(payload)["time"] for payload in listener.payloads()))

    wait_until(lambda: 500.0 in instants())
    assert instants() == [float(number) for number in range(70)] + [500.0]


SENDER = """
import sys, time
from hydrofdi.monitor.configuration import Address, MqttConfig
from hydrofdi.monitor.mqtt import MqttSink
MqttSink(Address.parse(sys.argv[1]), MqttConfig())
time.sleep(60)
"""


@contextmanager
def killed(command, **options):
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def test_the_broker_says_when_a_monitor_is_killed(broker, closing):
    with killed([sys.executable, "-c", SENDER, broker.address(LINES)]):
        listener = closing(Listener(broker))
        wait_until(lambda: listener.states == [b"online"])
    wait_until(lambda: listener.states == [b"online", b"offline"])
    late = closing(Listener(broker))
    wait_until(lambda: late.states == [b"offline"])


def test_lines_that_the_broker_refuses_are_said(tmp_path, closing):
    rules = tmp_path / "rules"
    rules.write_text(f"topic write {LINES}/status\ntopic read #\n")
    rules.chmod(0o644)
    with Broker(tmp_path, f"acl_file {rules}") as broker:
        sink = sink_at(broker)
        said_by(sink, [ALARM])
        wait_for(sink, EventKind.DROPPED)
        sink.close()


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
    files = ["--state", "state", "--log", "log", "--events", guarded.address("press/events")]
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
