"""Streams over MQTT in tests: blocks of samples, and what a source makes of them."""

import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from hydrofdi.monitor.configuration import Address, MonitorConfig, MqttConfig
from hydrofdi.monitor.mqtt import MqttSource, Publisher, payload_of
from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.description.sections import LimitsConfig
from hydrofdi.records.streams import Chunk, EventKind
from tests.monitor.streams import reading_of

DETECTOR = Path("detector.json")
SOON = 0.05
"""Before the second attempt to connect [s]."""

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
    limits = LimitsConfig.model_construct(payload=largest)
    whole = MonitorConfig.model_construct(mqtt=config or MqttConfig(), limits=limits)
    source = MqttSource(Address.parse(address), whole, detector, first_wait=SOON)
    if is_open:
        source.open({})
    return source


def publisher_at(address, config=None):
    return Publisher(Address.parse(address), config or MqttConfig(), 1000, first_wait=SOON)


def client_at(broker, client_id=""):
    """A client of its own, connected; with a name, the broker keeps what it misses."""
    client = Client(CallbackAPIVersion.VERSION2, client_id, protocol=MQTTProtocolVersion.MQTTv5)
    wishes = Properties(PacketTypes.CONNECT)
    wishes.SessionExpiryInterval = 600 if client_id else 0
    client.connect("127.0.0.1", broker.port, clean_start=not client_id, properties=wishes)
    client.loop_start()
    wait_for(client.is_connected)
    return client


def published(client, topic, payload, qos=1, retain=False):
    info = client.publish(topic, payload, qos, retain)
    info.wait_for_publish(30.0)
    assert info.is_published()


def wait_for(condition, timeout=30.0):
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


@contextmanager
def killed(command, **options):
    """A process that is killed at the end."""
    with subprocess.Popen(command, **options) as process:
        try:
            yield process
        finally:
            process.kill()


def until(source, condition, *, confirms=True, timeout=30.0):
    """All readings until a condition on them holds."""
    readings, end = [], time.monotonic() + timeout
    while not condition(readings):
        assert time.monotonic() < end, readings
        readings.append(reading_of(source, 0.02))
        if confirms and source.wants_confirmation:
            source.confirm()
    return readings


def events(readings, kind=None):
    return [event for each in readings for event in each.events if kind in (None, event.kind)]


def unread(readings):
    """Why messages could not be read."""
    return [text for each in readings if each.chunk for text in each.chunk.unread.values()]


def connected(source):
    """Wait for the connection."""
    return until(source, lambda readings: events(readings, EventKind.CONNECTED))


def times(readings):
    return np.concatenate([each.chunk.time for each in readings if each.chunk] or [np.empty(0)])


def through(*blocks):
    """Whether the last sample of the last block is there."""
    return lambda readings: blocks[-1].time[-1] in times(readings)


def samples(readings, channel):
    return np.concatenate([each.chunk.channels[channel] for each in readings if each.chunk])


def sent(publisher, blocks):
    for block in blocks:
        assert publisher.wait_until(19, 30.0)
        assert publisher.send(payload_of(block))
    assert publisher.wait_until(0, 30.0)
