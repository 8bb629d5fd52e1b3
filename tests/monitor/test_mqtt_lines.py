"""Lines and samples that are sent over MQTT: at least once, and without holding anybody up."""

import json
import sys
from dataclasses import replace

from hydrofdi.detectors.trained.judging import Verdict
from hydrofdi.monitor.configuration import MqttAddress, MqttConfig
from hydrofdi.monitor.lines import Condition, Event, EventKind, WindowLine
from hydrofdi.monitor.mqtt.sending import MqttSink
from tests.monitor.brokers import Broker, needs_mosquitto, running
from tests.monitor.mqtt_streams import SOON, client_at, killed, wait_for

pytestmark = needs_mosquitto

TOPIC = "press/lines"
ALARM = Event(EventKind.ALARM_RAISED, "the score 3.2 bar is above 2.1 bar", 12.5)
WINDOW = WindowLine(7, 10.0, 12.0, Verdict(score=1.5, alarm=False, margin=0.4), None, Condition.HEALTHY)


class Listener:
    """What is published under a topic, retained messages included."""

    def __init__(self, broker, topic=f"{TOPIC}/#", client_id=""):
        self.messages = []
        self._client = client_at(broker, client_id)
        self._client.on_message = lambda _, __, message: self.messages.append(message)
        self._client.on_subscribe = lambda *_: self.messages.append(None)
        self._client.subscribe(topic, qos=1)
        wait_for(lambda: None in self.messages)

    def payloads(self, topic=TOPIC):
        return [each.payload for each in self.messages if each and each.topic == topic]

    def close(self):
        self._client.disconnect()
        self._client.loop_stop()


def sink_at(broker, with_windows=False, **options):
    address, config = MqttAddress.parse(broker.address(TOPIC)), MqttConfig(windows=with_windows)
    return MqttSink(address, config, "bar", first_wait=SOON, **options)


def lines_until(sink, kind, lines=()):
    """What the sink says until it says something of this kind."""
    said = list(sink.put(None, lines))

    def has_said():
        said.extend(sink.put(None, []))
        return kind in [each.kind for each in said]

    wait_for(has_said)
    return said


def test_events_are_sent_and_windows_on_request(broker, closing):
    listener = closing(Listener(broker))
    for with_windows, expected in ((False, ["event"]), (True, ["window", "event"])):
        listener.messages.clear()
        sink = sink_at(broker, with_windows)
        sink.put(None, [WINDOW, ALARM, replace(ALARM, is_silent=True)])
        sink.close()
        wait_for(lambda: listener.payloads(f"{TOPIC}/status")[-1:] == [b"offline"])
        records = [json.loads(payload) for payload in listener.payloads()]
        assert [record["line"] for record in records] == expected
        assert records[-1]["text"] == ALARM.text


def test_lines_wait_for_a_broker_that_is_away_and_those_too_many_are_counted(tmp_path, closing):
    broker = Broker(tmp_path)
    sink = closing(sink_at(broker, capacity=50))
    events = [replace(ALARM, time=float(number)) for number in range(80)]
    said = [line for event in events for line in sink.put(None, [event])]
    dropped = [line for line in said if line.kind is EventKind.DROPPED]
    assert sum(line.count for line in dropped) == 30
    assert [line.is_silent for line in dropped] == [False] + [True] * 29
    broker.start()
    try:
        listener = closing(Listener(broker))
        lines_until(sink, EventKind.CONNECTED)
        assert sink._outbox.wait_until(0, 30.0)
        assert not [line for line in sink.put(None, [ALARM]) if line.kind is EventKind.DROPPED]
        assert sink._outbox.wait_until(0, 30.0)
    finally:
        sink.close()
        listener.close()
        broker.stop()


def test_lines_come_in_order_over_a_broker_that_starts_again(broker, closing):
    sink, listener = closing(sink_at(broker)), closing(Listener(broker, client_id="listener"))
    lines_until(sink, EventKind.CONNECTED)
    for number in range(60):
        if number == 20:
            broker.stop()
            lines_until(sink, EventKind.DISCONNECTED)
        if number == 40:
            broker.start()
        sink.put(None, [replace(ALARM, time=float(number))])

    def instants():
        return list(dict.fromkeys(json.loads(payload)["time"] for payload in listener.payloads()))

    wait_for(lambda: 59.0 in instants())
    assert instants() == [float(number) for number in range(60)]


SENDER = """
import sys, time
from hydrofdi.monitor.configuration import MqttAddress, MqttConfig
from hydrofdi.monitor.mqtt.sending import MqttSink
MqttSink(MqttAddress.parse(sys.argv[1]), MqttConfig())
time.sleep(60)
"""


def test_the_broker_says_when_a_monitor_is_killed(broker, closing):
    status = f"{TOPIC}/status"
    with killed([sys.executable, "-c", SENDER, broker.address(TOPIC)]):
        listener = closing(Listener(broker))
        wait_for(lambda: listener.payloads(status) == [b"online"])
    wait_for(lambda: listener.payloads(status) == [b"online", b"offline"])
    late = closing(Listener(broker))
    wait_for(lambda: late.payloads(status) == [b"offline"])


def test_lines_that_the_broker_refuses_are_said(tmp_path, closing):
    rules = tmp_path / "rules"
    rules.write_text(f"topic write {TOPIC}/status\ntopic read #\n")
    rules.chmod(0o644)
    for broker in running(Broker(tmp_path, f"acl_file {rules}")):
        sink = closing(sink_at(broker))
        lines_until(sink, EventKind.DROPPED, [ALARM])
        sink.close()
