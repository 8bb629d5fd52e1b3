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

from hydrofdi.detectors.lines import Condition, WindowLine, line_record
from hydrofdi.detectors.verdicts import Verdict
from hydrofdi.monitor import topics
from hydrofdi.monitor.configuration import Address, FleetConfig, MonitorConfig, MqttConfig, Pattern
from hydrofdi.monitor.mqtt import MqttSink, Publisher, payload_of
from hydrofdi.monitor.sources import StreamSource
from hydrofdi.monitor.topics import Topics, TopicSource
from hydrofdi.records import Channel
from hydrofdi.records.description import RemarkLimits
from hydrofdi.records.streams import Chunk, Event, EventKind
from tests.commands import COMMAND, wait_until
from tests.commands import run as run_command
from tests.monitor.brokers import SECRET, Broker, client_at, needs_mosquitto, running
from tests.monitor.streams import reading_of

DETECTOR = Path("detector.json")
P1, U = Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE


def blocks_of(n_block, n_sample=100):
    rng = np.random.default_rng(13)
    return [
        Chunk(
            (n_sample * number + np.arange(n_sample)) / 1000,
            {P1: rng.normal(5e6, 1e5, n_sample), U: rng.normal(size=n_sample)},
        )
        for number in range(n_block)
    ]


def source_at(address, config=None, detector=DETECTOR, is_open=True, largest=2**20):
    limits = RemarkLimits.model_construct(payload=largest)
    whole = MonitorConfig.model_construct(mqtt=config or MqttConfig(), limits=limits)
    source = Topic(Address.parse(address), whole, detector)
    if is_open:
        source.open({})
    return source


class Topic(StreamSource):
    """A topic by itself, over a connection as that of a single machine."""

    def __init__(self, address, config, detector):
        fleet = FleetConfig.model_construct(**dict(config))
        patterns = [Pattern(address, address.path)]
        self.topics = Topics(patterns, fleet, detector, is_single=True)
        self.source = TopicSource(str(address), config, (), address)
        super().__init__(str(address), self.topics.events)
        self.client_id, self.inbox = self.topics.client_id, self.topics._inbox

    def open(self, position):
        self.topics.connect()

    def read(self, timeout):
        self.topics.dispatch(lambda *_: self.source, timeout or 1e-6)
        return self.source.read(0.0)

    def confirm(self):
        self.source.confirm()
        self.topics.acknowledge()

    def close(self):
        self.topics.close()


def publisher_at(address):
    return Publisher(Address.parse(address), MqttConfig(), 1000)


@contextmanager
def killed(command, **options):
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def until(source, condition, *, confirms=True, timeout=30.0):
    readings, end = [], time.monotonic() + timeout
    while not condition(readings):
        assert time.monotonic() < end, readings
        readings.append(reading_of(source, 0.02))
        if confirms and source.topics.blocking():
            source.confirm()
    return readings


def events(readings, kind=None):
    return [event for each in readings for event in each.events if kind in (None, event.kind)]


def unread(readings):
    return [text for each in readings if each.chunk for text in each.chunk.unread.values()]


def connected(source):
    return until(source, lambda readings: events(readings, EventKind.CONNECTED))


def times(readings):
    return np.concatenate([each.chunk.time for each in readings if each.chunk] or [np.empty(0)])


def through(*blocks):
    return lambda readings: blocks[-1].time[-1] in times(readings)


def samples(readings, channel):
    return np.concatenate([each.chunk.channels[channel] for each in readings if each.chunk])


def sent(publisher, blocks):
    for block in blocks:
        assert publisher.wait_until(19, 30.0)
        assert publisher.send(payload_of(block))
    assert publisher.wait_until(0, 30.0)


pytestmark = needs_mosquitto


def all_times(blocks):
    return np.concatenate([block.time for block in blocks])


def test_detectors_of_one_file_name_do_not_throw_each_other_out(broker, closing, tmp_path, monkeypatch):
    """A path names the detector, however it is written; the broker does not see it."""
    blocks = blocks_of(10)
    monkeypatch.chdir(tmp_path)
    paths = [tmp_path / "press" / "detector.json", tmp_path / "crane" / "detector.json"]
    sources = [closing(source_at(broker.address(), detector=path)) for path in paths]
    for source in sources:
        connected(source)
    sent(closing(publisher_at(broker.address())), blocks)
    for source in sources:
        readings = until(source, through(*blocks))
        np.testing.assert_array_equal(times(readings), all_times(blocks))
        for channel in (P1, U):
            expected = np.concatenate([block.channels[channel] for block in blocks])
            np.testing.assert_array_equal(samples(readings, channel), expected)
        assert not events(readings)
        assert "press" not in source.client_id
    short = source_at(broker.address(), detector=Path("press/detector.json"), is_open=False)
    assert short.client_id == sources[0].client_id


def test_a_slow_monitor_holds_the_network_up_and_loses_nothing(broker, closing, monkeypatch):
    """However many messages the broker sends at once."""
    monkeypatch.setattr(topics, "CAPACITY", 10 * topics.LEAST_OF_ONE)
    monkeypatch.setattr(topics, "AT_ONCE", 3 * topics.LEAST_OF_ONE)
    blocks = blocks_of(300)
    source = closing(source_at(broker.address()))
    connected(source)
    sent(closing(publisher_at(broker.address())), blocks)
    n_waiting, readings = [], []
    while not through(*blocks)(readings):
        wait_until(lambda: source.inbox._items)
        n_waiting.append(len(source.inbox._items))
        readings.append(reading_of(source, 0.0))
        source.confirm()
    assert max(n_waiting) == 10
    np.testing.assert_array_equal(times(readings), all_times(blocks))
    assert not events(readings)


@pytest.mark.parametrize("confirms", [True, False])
def test_a_broker_that_is_absent_is_waited_for_and_one_that_starts_again_loses_nothing(
    broker, closing, confirms
):
    """Unconfirmed messages are sent again by the broker; the source knows them."""
    blocks = blocks_of(40)
    broker.stop()
    source = closing(source_at(broker.address()))
    (said,) = events([reading_of(source, 0.1) for _ in range(10)])
    assert said.kind == "disconnected"
    broker.start()
    assert [event.kind for event in events(connected(source))] == ["connected"]
    publisher = closing(publisher_at(broker.address()))
    sent(publisher, blocks[:10])
    before = until(source, through(*blocks[:10]), confirms=confirms)
    broker.stop()
    for block in blocks[10:20]:
        assert publisher.send(payload_of(block))
    away = until(source, lambda readings: events(readings, EventKind.DISCONNECTED))
    broker.start()
    sent(publisher, blocks[20:])
    after = until(
        source, lambda readings: through(*blocks)(readings) and events(readings, EventKind.CONNECTED)
    )
    np.testing.assert_array_equal(times([*before, *away, *after]), all_times(blocks))
    said = events([*away, *after])
    assert [kind for kind, _ in groupby(event.kind for event in said)] == ["disconnected", "connected"]
    assert len({event.text for event in said}) == len(said)


def test_a_confirmation_that_the_broker_did_not_get_is_sent_again(broker, closing):
    blocks = blocks_of(8)
    source = source_at(broker.address())
    connected(source)
    sent(closing(publisher_at(broker.address())), blocks[:7])
    until(source, through(*blocks[:7]), confirms=False)
    broker.stop()
    until(source, lambda readings: events(readings, EventKind.DISCONNECTED), confirms=False)
    source.confirm()
    broker.start()
    connected(source)
    until(source, lambda _: broker.log.count(f"Received PUBACK from {source.client_id}") == 7)
    source.close()
    again = closing(source_at(broker.address()))
    connected(again)
    sent(closing(publisher_at(broker.address())), blocks[7:])
    np.testing.assert_array_equal(times(until(again, through(*blocks[7:]))), blocks[7].time)


def test_messages_that_wait_while_the_connection_breaks_come_once(broker, closing):
    blocks = blocks_of(15)
    source = closing(source_at(broker.address()))
    connected(source)
    sent(closing(publisher_at(broker.address())), blocks)
    wait_until(lambda: len(source.inbox._items) == 15)
    with client_at(broker, source.client_id):
        wait_until(lambda: "taken over" in broker.log or "already connected" in broker.log)
    readings = until(source, lambda readings: len(events(readings, EventKind.CONNECTED)) == 1)
    np.testing.assert_array_equal(times(readings), all_times(blocks))


def test_messages_that_are_no_samples_are_counted_and_done_with(broker, closing):
    block, later, old = blocks_of(3)
    with client_at(broker) as client:

        def published(payload, retain=False):
            client.publish("press/samples", payload, 1, retain).wait_for_publish(30.0)

        published(payload_of(old), retain=True)  # of long ago: it is not read
        source = source_at(broker.address(), largest=10_000)
        connected(source)
        for payload in (b"no JSON", b"", b"\xff\x00", b'{"time": 1}', b"7" * 20_000, payload_of(block)):
            published(payload)
        readings = until(source, through(block))
        source.confirm()
        np.testing.assert_array_equal(times(readings)[np.isfinite(times(readings))], block.time)
        assert len(unread(readings)) == 5
        source.close()
        wait_until(lambda: f"{source.client_id} disconnected" in broker.log)
        again = closing(source_at(broker.address(), largest=10_000))
        published(payload_of(later))
        assert not unread(until(again, through(later)))


TOPIC_LINES = "press/lines"
ALARM = Event(EventKind.ALARM_RAISED, "the score 3.2 bar is above 2.1 bar", 12.5)
WINDOW = WindowLine(7, 10.0, 12.0, Verdict(score=1.5, alarm=False, margin=0.4), None, Condition.HEALTHY)


class Listener:
    """What is published under a topic, retained messages included."""

    def __init__(self, broker, topic=f"{TOPIC_LINES}/#", client_id=""):
        self.messages, self._stack = [], ExitStack()
        client = self._stack.enter_context(client_at(broker, client_id))
        client.on_message = lambda _, __, message: self.messages.append(message)
        client.on_subscribe = lambda *_: self.messages.append(None)
        client.subscribe(topic, qos=1)
        wait_until(lambda: None in self.messages)
        self.close = self._stack.close

    def payloads(self, topic=TOPIC_LINES):
        return [each.payload for each in self.messages if each and each.topic == topic]


def sink_at(broker, with_windows=False, **options):
    address, config = Address.parse(broker.address(TOPIC_LINES)), MqttConfig(windows=with_windows)
    return MqttSink(address, config, **options)


def said_by(sink, lines):
    """Send lines that it wants; what happened to those before."""
    return sink.send_all([json.dumps(line_record(line)) for line in lines if sink.wants(line)])


def lines_until(sink, kind, lines=()):
    """What the sink says until it says something of this kind."""
    said = list(said_by(sink, lines))

    def has_said():
        said.extend(said_by(sink, []))
        return kind in [each.kind for each in said]

    wait_until(has_said)
    return said


def test_events_are_sent_and_windows_on_request(broker, closing):
    listener = closing(Listener(broker))
    for with_windows, expected in ((False, ["event"]), (True, ["window", "event"])):
        listener.messages.clear()
        sink = sink_at(broker, with_windows)
        said_by(sink, [WINDOW, ALARM, replace(ALARM, is_silent=True)])
        sink.close()
        wait_until(lambda: listener.payloads(f"{TOPIC_LINES}/status")[-1:] == [b"offline"])
        records = [json.loads(payload) for payload in listener.payloads()]
        assert [record["line"] for record in records] == expected
        assert records[-1]["text"] == ALARM.text


def test_lines_wait_for_a_broker_that_is_away_and_those_too_many_are_counted(broker, closing):
    broker.stop()
    sink = closing(sink_at(broker, capacity=50))
    events = [replace(ALARM, time=float(number)) for number in range(80)]
    said = [line for event in events for line in said_by(sink, [event])]
    dropped = [line for line in said if line.kind is EventKind.DROPPED]
    assert sum(line.count for line in dropped) == 30
    assert [line.is_silent for line in dropped] == [False] + [True] * 29
    broker.start()
    lines_until(sink, EventKind.CONNECTED)
    for sent_now in ([], [ALARM]):
        assert not [line for line in said_by(sink, sent_now) if line.kind is EventKind.DROPPED]
        assert sink.wait_until(0, 30.0)


def test_lines_come_in_order_over_a_broker_that_starts_again(broker, closing):
    sink, listener = closing(sink_at(broker)), closing(Listener(broker, client_id="listener"))
    lines_until(sink, EventKind.CONNECTED)
    for number in range(60):
        if number == 20:
            broker.stop()
            lines_until(sink, EventKind.DISCONNECTED)
        if number == 40:
            broker.start()
        said_by(sink, [replace(ALARM, time=float(number))])

    def instants():
        return list(dict.fromkeys(json.loads(payload)["time"] for payload in listener.payloads()))

    wait_until(lambda: 59.0 in instants())
    assert instants() == [float(number) for number in range(60)]


SENDER = """
import sys, time
from hydrofdi.monitor.configuration import Address, MqttConfig
from hydrofdi.monitor.mqtt import MqttSink
MqttSink(Address.parse(sys.argv[1]), MqttConfig())
time.sleep(60)
"""


def test_the_broker_says_when_a_monitor_is_killed(broker, closing):
    status = f"{TOPIC_LINES}/status"
    with killed([sys.executable, "-c", SENDER, broker.address(TOPIC_LINES)]):
        listener = closing(Listener(broker))
        wait_until(lambda: listener.payloads(status) == [b"online"])
    wait_until(lambda: listener.payloads(status) == [b"online", b"offline"])
    late = closing(Listener(broker))
    wait_until(lambda: late.payloads(status) == [b"offline"])


def test_lines_that_the_broker_refuses_are_said(tmp_path, closing):
    rules = tmp_path / "rules"
    rules.write_text(f"topic write {TOPIC_LINES}/status\ntopic read #\n")
    rules.chmod(0o644)
    for broker in running(Broker(tmp_path, f"acl_file {rules}")):
        sink = closing(sink_at(broker))
        lines_until(sink, EventKind.DROPPED, [ALARM])
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
                wait_until(lambda number=number: len(windows(folder / "log")) >= number)
                arguments.append(Path(f"/proc/{life.pid}/cmdline").read_text())
    assert windows(folder / "log") == expected
    shown = [file.read_bytes() for file in folder.iterdir()] + [guarded.log.encode()]
    assert len(shown) >= 4
    assert not [text for text in shown if SECRET.encode() in text]
    assert SECRET not in "".join(arguments)
