"""Samples over MQTT, by a real broker on this machine."""

from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.mqtt import source as mqtt_source
from hydrofdi.monitor.mqtt.sending import payload_of
from tests.monitor.brokers import Broker, needs_mosquitto
from tests.monitor.mqtt_streams import (
    P1,
    U,
    blocks_of,
    client_at,
    connected,
    events,
    published,
    publisher_at,
    samples,
    sent,
    source_at,
    through,
    times,
    unread,
    until,
    wait_for,
)

pytestmark = needs_mosquitto

TOPIC = "press/samples"


def all_times(blocks):
    return np.concatenate([block.time for block in blocks])


def test_samples_arrive_in_order_and_to_the_bit(broker, closing):
    blocks = blocks_of(60)
    source = closing(source_at(broker.address()))
    connected(source)
    sent(closing(publisher_at(broker.address())), blocks)
    readings = until(source, through(*blocks))
    np.testing.assert_array_equal(times(readings), all_times(blocks))
    for channel in (P1, U):
        expected = np.concatenate([block.channels[channel] for block in blocks])
        np.testing.assert_array_equal(samples(readings, channel), expected)


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
        assert not events(readings)
        assert "press" not in source._connection.client_id
    short = source_at(broker.address(), detector=Path("press/detector.json"), is_open=False)
    assert short._connection.client_id == sources[0]._connection.client_id


def test_a_slow_monitor_holds_the_network_up_and_loses_nothing(broker, closing, monkeypatch):
    """However many messages the broker sends at once."""
    monkeypatch.setattr(mqtt_source, "CAPACITY", 10 * mqtt_source.LEAST_SIZE)
    monkeypatch.setattr(mqtt_source, "AT_ONCE", 3 * mqtt_source.LEAST_SIZE)
    blocks = blocks_of(300)
    source = closing(source_at(broker.address()))
    connected(source)
    sent(closing(publisher_at(broker.address())), blocks)
    n_waiting, readings = [], []
    while not through(*blocks)(readings):
        wait_for(lambda: source._inbox._items)
        n_waiting.append(len(source._inbox._items))
        readings.append(source.read(0.0))
        source.confirm()
    assert max(n_waiting) == 10
    np.testing.assert_array_equal(times(readings), all_times(blocks))
    assert not events(readings)


@pytest.mark.parametrize("confirms", [True, False])
def test_a_broker_that_starts_again_loses_nothing(broker, closing, confirms):
    """Unconfirmed messages are sent again by the broker; the source knows them."""
    blocks = blocks_of(40)
    source = closing(source_at(broker.address()))
    connected(source)
    publisher = closing(publisher_at(broker.address()))
    sent(publisher, blocks[:10])
    before = until(source, through(*blocks[:10]), confirms=confirms)
    broker.stop()
    for block in blocks[10:20]:
        assert publisher.send(block)
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
    until(source, lambda _: broker.log.count(f"Received PUBACK from {source._connection.client_id}") == 7)
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
    wait_for(lambda: len(source._inbox._items) == 15)
    intruder = client_at(broker, source._connection.client_id)
    wait_for(lambda: "taken over" in broker.log or "already connected" in broker.log)
    intruder.disconnect()
    intruder.loop_stop()
    readings = until(source, lambda readings: len(events(readings, EventKind.CONNECTED)) == 1)
    np.testing.assert_array_equal(times(readings), all_times(blocks))


def test_a_broker_that_is_absent_is_waited_for_and_said_once(tmp_path, closing):
    broker = Broker(tmp_path)
    source = closing(source_at(broker.address()))
    try:
        absent = [source.read(0.1) for _ in range(10)]
        broker.start()
        present = connected(source)
    finally:
        broker.stop()
    (said,) = events(absent)
    assert said.kind == "disconnected"
    assert [event.kind for event in events(present)] == ["connected"]


def test_messages_that_are_no_samples_are_counted_and_done_with(broker, closing):
    (block,) = blocks_of(1)
    source = source_at(broker.address(), largest=10_000)
    connected(source)
    client = client_at(broker)
    for payload in (b"no JSON", b"", b"\xff\x00", b'{"time": 1}', b"7" * 20_000, payload_of(block)):
        published(client, TOPIC, payload)
    readings = until(source, through(block))
    source.confirm()
    assert len(unread(readings)) == 5
    assert unread(readings)[0] == "malformed message 'no JSON': is not JSON"
    source.close()
    wait_for(lambda: f"{source._connection.client_id} disconnected" in broker.log)
    again = closing(source_at(broker.address(), largest=10_000))
    published(client, TOPIC, payload_of(blocks_of(2)[1]))
    readings = until(again, through(blocks_of(2)[1]))
    assert not unread(readings)
    client.disconnect()
    client.loop_stop()


def test_a_sample_of_long_ago_that_the_broker_retains_is_not_read(broker, closing):
    old, new = blocks_of(2)
    client = client_at(broker)
    published(client, TOPIC, payload_of(old), retain=True)
    source = closing(source_at(broker.address()))
    connected(source)
    published(client, TOPIC, payload_of(new))
    np.testing.assert_array_equal(times(until(source, through(new))), new.time)
    client.disconnect()
    client.loop_stop()


def test_messages_that_the_broker_does_not_keep_are_lost_in_one_gap(broker, closing, monkeypatch):
    blocks = blocks_of(30)
    monkeypatch.setattr(mqtt_source, "CAPACITY", 10 * mqtt_source.LEAST_SIZE)
    source = closing(source_at(broker.address()))
    connected(source)
    client = client_at(broker)
    for block in blocks[:29]:
        client.publish(TOPIC, payload_of(block), qos=0)
    published(client, "other", b"")
    wait_for(lambda: source._inbox._n_dropped == 28 - len(source._inbox._items))
    full = until(source, lambda readings: events(readings, EventKind.DROPPED))
    client.publish(TOPIC, payload_of(blocks[29]), qos=0)
    after = until(source, through(blocks[29]))
    n_kept = len(times(full)) // 100
    np.testing.assert_array_equal(times(full), all_times(blocks[:n_kept]))
    assert sum(event.count for event in events(full, EventKind.DROPPED)) == 29 - n_kept
    np.testing.assert_array_equal(times(after), blocks[29].time)
    client.disconnect()
    client.loop_stop()
