import time
from contextlib import contextmanager
from threading import enumerate as threads

import numpy as np
import pytest
from asyncua import ua

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.lines import EventKind
from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.monitor.sources.opcua import OpcUaSource
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from tests.monitor.opcua_server import EPOCH, LoopbackServer, free_port

P1, X = Channel.CHAMBER_1_PRESSURE, Channel.PISTON_POSITION
CHANNELS = {
    P1: ChannelConfig(column="ns=1;s=P1", unit="bar"),
    X: ChannelConfig(column="ns=1;s=x", unit="mm", gain=2.0, offset=1.0, sign=-1),
}
NODES = {"P1": 0.0, "x": 0.0}
FAST = OpcUaConfig(publishing_interval=0.05, wait=0.5)
RATE = 100.0
CODES = ua.StatusCodes


@pytest.fixture(scope="module")
def server():
    with LoopbackServer({**NODES, "text": ""}) as running:
        yield running


@contextmanager
def opened(url, config=FAST, channels=CHANNELS):
    source = OpcUaSource(url, config, channels, RATE, first_wait=0.1)
    source.open({})
    try:
        yield source
    finally:
        source.close()


class Reader:
    """What a source gave, until something is there or a minute has passed."""

    def __init__(self, source):
        self._source, self.chunks, self.events = source, [], []

    def until(self, is_there):
        deadline = time.monotonic() + 20
        while not is_there(self):
            assert time.monotonic() < deadline, (self.time.size, self.events)
            reading = self._source.read(0.2)
            self.chunks += [reading.chunk] if reading.chunk else []
            self.events += reading.events
        return self

    def has(self, kind, times=1):
        return self.until(lambda reader: len(reader.said(kind)) >= times)

    def samples(self, count):
        return self.until(lambda reader: reader.time.size >= count)

    def said(self, kind):
        return [event.text for event in self.events if event.kind is kind and not event.is_silent]

    @property
    def time(self):
        return np.concatenate([[], *(chunk.time for chunk in self.chunks)]) - EPOCH.timestamp()

    def channel(self, channel):
        return np.concatenate([chunk.channels[channel] for chunk in self.chunks])


def connected(source):
    """A reader of a source whose nodes have all sent their value of before."""
    reader = Reader(source).has(EventKind.CONNECTED)
    time.sleep(0.2)
    return reader


def test_samples_are_those_of_the_server_to_the_bit(server):
    rng = np.random.default_rng(1)
    pressure, position = rng.normal(50.0, 1.0, 200), np.repeat(rng.normal(0.0, 9.0, 4), 50)
    times = np.arange(200) / RATE
    with opened(server.url) as source:
        reader = connected(source)
        server.write("P1", pressure.tolist(), times)
        server.write("x", position.tolist(), times)
        reader.samples(200)
    np.testing.assert_array_equal(reader.channel(P1), pressure * 1e5)
    np.testing.assert_array_equal(reader.channel(X), -(2.0 * position + 1.0) / 1e3)
    np.testing.assert_allclose(reader.time, times, atol=1e-6)


def test_a_value_whose_status_is_not_good_is_missing(server):
    times = 10.0 + np.arange(4) / RATE
    with opened(server.url) as source:
        reader = connected(source)
        server.write(
            "P1",
            [1.0, 2.0, 3.0, 4.0],
            times,
            [CODES.Good, CODES.Bad, CODES.UncertainLastUsableValue, CODES.Good],
        )
        server.write("x", [1.0, 2.0, 3.0, 4.0], times)
        reader.samples(4)
    assert np.isnan(reader.channel(P1)).tolist() == [False, True, True, False]
    assert not np.isnan(reader.channel(X)).any()


def test_a_node_may_hold_an_array_of_consecutive_samples(server):
    with LoopbackServer({name: [0.0] for name in NODES}) as blocks, opened(blocks.url) as source:
        reader = connected(source)
        for block in range(3):
            values = np.arange(50.0) + 50 * block
            for name in ("P1", "x"):
                blocks.write(name, [values.tolist()], [0.5 * (block + 1)])
        reader.samples(150)
    np.testing.assert_array_equal(reader.channel(P1), np.arange(150) * 1e5)
    np.testing.assert_allclose(np.diff(reader.time), 1 / RATE, atol=1e-6)


def test_a_server_that_comes_goes_and_comes_back_is_followed():
    port = free_port()
    with opened(f"opc.tcp://127.0.0.1:{port}/plant") as source:
        reader = Reader(source).has(EventKind.DISCONNECTED)
        for count in (1, 2):
            with LoopbackServer(NODES, port) as server:
                reader.has(EventKind.CONNECTED, times=count)
                time.sleep(0.2)
                for name in NODES:
                    server.write(name, [2.0 * count, 3.0 * count], [count, count + 0.01])
                reader.samples(2 * count)
            reader.has(EventKind.DISCONNECTED, times=count + 1)
    assert reader.channel(P1).tolist() == [2e5, 3e5, 4e5, 6e5]
    absent, *gone = reader.said(EventKind.DISCONNECTED)
    assert "connection refused" in absent
    assert len(gone) == 2
    assert "not encrypted" in reader.said(EventKind.CONNECTED)[0]


def test_an_unknown_node_is_named(server):
    channels = {P1: ChannelConfig(column="ns=1;s=P7", unit="bar")}
    with opened(server.url, channels=channels) as source:
        (said,) = Reader(source).has(EventKind.DISCONNECTED).said(EventKind.DISCONNECTED)
    assert "no variable ns=1;s=P7" in said


def test_a_node_without_numbers_is_said_once_and_counted(server):
    channels = {P1: ChannelConfig(column="ns=1;s=text", unit="bar")}
    with opened(server.url, channels=channels) as source:
        reader = connected(source)
        server.write("text", ["a", "b"], [20.0, 20.01])
        reader.until(lambda reader: sum(e.kind is EventKind.MALFORMED for e in reader.events) == 2)
    (said,) = reader.said(EventKind.MALFORMED)
    assert "ns=1;s=text holds a str instead of a number" in said


def test_a_source_that_is_closed_leaves_no_thread_and_no_subscription(server):
    with opened(server.url) as source:
        connected(source)
        assert server.n_subscription == 1
    assert not [thread for thread in threads() if thread.name == "opcua"]
    assert server.n_subscription == 0


def test_a_source_that_never_connected_is_closed_at_once():
    with opened(f"opc.tcp://127.0.0.1:{free_port()}") as source:
        Reader(source).has(EventKind.DISCONNECTED)
    assert not [thread for thread in threads() if thread.name == "opcua"]


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"column": "P1", "unit": "bar"}, "'P1' is no node id"),
        ({"column": "ns=1;s=P1"}, "write the 'unit' of the node"),
        ({"column": "ns=1;s=P1", "unit": "mm"}, "not convertible to Pa"),
    ],
)
def test_a_channel_that_cannot_be_read_is_refused_before_it_is_connected(config, message):
    with pytest.raises(ValueError, match=message):
        OpcUaSource("opc.tcp://127.0.0.1", FAST, {P1: ChannelConfig(**config)}, RATE)


@pytest.mark.parametrize("url", ["opc.tcp://", "http://host", "opc.tcp://host:99999", "opc.tcp://host/x?y"])
def test_what_is_no_address_is_refused(url):
    with pytest.raises(ConfigError, match=r"written opc\.tcp://host:port/path"):
        OpcUaSource(url, FAST, CHANNELS, RATE)


def test_credentials_in_an_address_are_refused_and_not_repeated():
    with pytest.raises(ConfigError) as error:
        OpcUaSource("opc.tcp://me:secret@host", FAST, CHANNELS, RATE)
    assert "secret" not in str(error.value)
