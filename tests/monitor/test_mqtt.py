"""Samples over MQTT, by a real broker on this machine."""

import time

import numpy as np
import pytest

from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.mqtt import MqttAddress, MqttConfig
from hydrofdi.monitor.mqtt.publisher import SamplePublisher
from hydrofdi.monitor.sources.mqtt import MqttSource
from hydrofdi.monitor.sources.payload import PayloadReader
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Chunk
from tests.monitor.brokers import Broker, needs_mosquitto

pytestmark = needs_mosquitto

RNG = np.random.default_rng(13)
BLOCKS = [
    Chunk(
        (100 * number + np.arange(100)) / 1000,
        {Channel.CHAMBER_1_PRESSURE: RNG.normal(5e6, 1e5, 100), Channel.INPUT_VOLTAGE: RNG.normal(size=100)},
    )
    for number in range(60)
]


@pytest.fixture
def broker(tmp_path):
    broker = Broker(tmp_path)
    try:
        broker.start()
        yield broker
    finally:
        broker.stop()


@pytest.fixture
def opened():
    """Closes what a test opened."""
    things = []
    yield things
    for thing in things:
        thing.close()


def source_at(broker, opened, **options):
    address = MqttAddress.parse(broker.address())
    source = MqttSource(address, MqttConfig(), PayloadReader().read, "d.json", first_wait=0.05, **options)
    source.open({})
    opened.append(source)
    return source


def publisher_at(broker, opened):
    publisher = SamplePublisher(MqttAddress.parse(broker.address()), MqttConfig(), first_wait=0.05)
    opened.append(publisher)
    return publisher


def until(source, condition, *, confirms=True, timeout=30.0):
    """All readings until a condition on them holds."""
    readings, end = [], time.monotonic() + timeout
    while not condition(readings):
        assert time.monotonic() < end, readings
        readings.append(source.read(0.05))
        if confirms and source.wants_confirmation:
            source.confirm()
    return readings


def kinds(readings):
    return [event.kind for reading in readings for event in reading.events]


def times(readings):
    return np.concatenate([reading.chunk.time for reading in readings if reading.chunk] or [np.empty(0)])


def ended(block):
    return lambda readings: block.time[-1] in times(readings)


def is_connected(readings):
    return EventKind.CONNECTED in kinds(readings)


def sent(publisher, blocks):
    for block in blocks:
        assert publisher.send(block, timeout=30.0)
    assert publisher.flush(30.0)


def samples(readings, channel):
    return np.concatenate([reading.chunk.channels[channel] for reading in readings if reading.chunk])


def test_samples_arrive_to_the_bit_and_in_order(broker, opened):
    source = source_at(broker, opened)
    until(source, is_connected)
    sent(publisher_at(broker, opened), BLOCKS)
    readings = until(source, ended(BLOCKS[-1]))
    np.testing.assert_array_equal(times(readings), np.concatenate([block.time for block in BLOCKS]))
    for channel in BLOCKS[0].channels:
        expected = np.concatenate([block.channels[channel] for block in BLOCKS])
        np.testing.assert_array_equal(samples(readings, channel), expected)


def test_what_was_not_confirmed_comes_again_after_a_restart(broker, opened):
    first = source_at(broker, opened)
    until(first, is_connected)
    publisher = publisher_at(broker, opened)
    sent(publisher, BLOCKS[:30])
    confirmed = until(first, lambda readings: len(times(readings)) >= 1000)
    lost = until(first, ended(BLOCKS[29]) if first.wants_confirmation else bool, confirms=False)
    first.close()
    sent(publisher, BLOCKS[30:])
    second = source_at(broker, opened)
    again = until(second, ended(BLOCKS[-1]))
    assert set(times(confirmed)) | set(times(again)) == {t for block in BLOCKS for t in block.time}
    assert set(times(lost)) <= set(times(again))
