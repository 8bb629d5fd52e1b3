"""Nodes of an OPC UA server as a stream."""

import asyncio
import time
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from threading import Thread
from threading import enumerate as threads

import numpy as np
import pytest
from asyncua import Server, ua

from hydrofdi.monitor import sources
from hydrofdi.monitor.configuration import Address, OpcUaConfig
from hydrofdi.monitor.opcua import OpcUaSource
from hydrofdi.monitor.sources import Inbox, joined
from hydrofdi.records import Channel
from hydrofdi.records.description import ChannelConfig
from hydrofdi.records.streams import EventKind, Joining
from tests.monitor.brokers import free_port
from tests.monitor.streams import Reader

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)


class LoopbackServer:
    """Variables ``ns=1;s=NAME``, written from the test with time stamps of its own."""

    def __init__(self, initial, port=None, set_up=None, user_manager=None):
        self.url = f"opc.tcp://127.0.0.1:{port or free_port()}/plant"
        self._initial, self._set_up, self._user_manager = initial, set_up, user_manager
        self._loop = asyncio.new_event_loop()
        self._thread = Thread(target=self._loop.run_forever)

    def __enter__(self):
        self._thread.start()
        try:
            self.do(self._start())
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, *_):
        try:
            self.do(self._server.stop())
        finally:
            self._end()

    def vanish(self):
        """Close every connection, and listen no more."""
        self.do(self._server.bserver.stop())

    def appear(self):
        self.do(self._server.bserver.start())

    def do(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(60)

    def write(self, name, values, times, statuses=None):
        """Values one after the other, at `times` seconds after EPOCH."""
        statuses = statuses or [ua.StatusCodes.Good] * len(values)
        self.do(self._write(self._nodes[name].nodeid, zip(values, times, statuses, strict=True)))

    @property
    def n_subscription(self):
        return len(self._server.iserver.subscription_service.subscriptions)

    async def _start(self):
        self._server = Server(user_manager=self._user_manager)
        await self._server.init()
        self._server.set_endpoint(self.url)
        self._server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        if self._set_up is not None:
            await self._set_up(self._server)
        self._nodes = {}
        for name, initial in self._initial.items():
            node = ua.NodeId(name, 1)
            self._nodes[name] = await self._server.nodes.objects.add_variable(node, name, initial)
        await self._server.start()

    async def _write(self, node, samples):
        for value, instant, status in samples:
            stamp = EPOCH + timedelta(seconds=instant)
            data = ua.DataValue(ua.Variant(value), ua.StatusCode(status), SourceTimestamp=stamp)
            await self._server.write_attribute_value(node, data)

    def _end(self):
        """Also tasks that the server does not end by itself."""

        async def cancel():
            left = asyncio.all_tasks() - {asyncio.current_task()}
            for task in left:
                task.cancel()
            await asyncio.gather(*left, return_exceptions=True)

        self.do(cancel())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


P1, X = Channel.CHAMBER_1_PRESSURE, Channel.PISTON_POSITION
CHANNELS = {
    P1: ChannelConfig(column="ns=1;s=P1", unit="bar"),
    X: ChannelConfig(column="ns=1;s=x", unit="mm", gain=2.0, offset=1.0, sign=-1),
}
NODES = {"P1": 0.0, "x": 0.0}
FAST = OpcUaConfig(publishing_interval=0.05)
RATE = 100.0


@contextmanager
def opened(url, config=FAST, channels=CHANNELS, rate=RATE):
    source = OpcUaSource(Address.parse(url), config, channels, rate)
    source.open({})
    try:
        yield source
    finally:
        source.close()


def connected(source):
    """A reader of a source whose nodes have all sent their value of before."""
    reader = Reader(source).has(EventKind.CONNECTED)
    time.sleep(0.2)
    return reader


def whole(reader, n_value):
    """Instants and samples of so many values, joined as a detector does."""
    reader.until(lambda: reader.times.size >= n_value)
    joining = Joining(RATE, (P1, X))
    _, chunk = joining.step(joining.start(), joined(reader.chunks), is_end=True)
    return chunk.time, chunk.channels


CODES = ua.StatusCodes


@pytest.fixture(scope="module")
def server():
    with LoopbackServer({**NODES, "P1s": [0.0], "xs": [0.0]}) as running:
        yield running


def test_samples_are_those_of_the_server_to_the_bit_and_missing_if_their_status_is_not_good(server):
    """A full queue of the server is said; a source that is closed leaves no thread and no subscription."""
    rng = np.random.default_rng(1)
    pressure, position = rng.normal(50.0, 1.0, 200), np.repeat(rng.normal(0.0, 9.0, 4), 50)
    times, codes = np.arange(200) / RATE, [CODES.Good] * 200
    codes[150:153] = [ua.StatusCode(0x480).value, CODES.Bad, CODES.UncertainLastUsableValue]
    with opened(server.url) as source:
        reader = connected(source)
        during = server.n_subscription
        server.write("P1", pressure.tolist(), times, codes)
        server.write("x", position.tolist(), times)
        times_read, samples = whole(reader.has(EventKind.DROPPED), 400)
    assert not [thread for thread in threads() if thread.name == "opcua"]
    assert server.n_subscription < during
    pressure[151:153] = np.nan
    np.testing.assert_array_equal(samples[P1], pressure * 1e5)
    np.testing.assert_array_equal(samples[X], -(2.0 * position + 1.0) / 1e3)
    np.testing.assert_allclose(times_read - EPOCH.timestamp(), times, atol=1e-6)


def test_a_node_may_hold_an_array_of_consecutive_samples(server):
    channels = {key: each.model_copy(update={"column": f"{each.column}s"}) for key, each in CHANNELS.items()}
    with opened(server.url, channels=channels) as source:
        reader = connected(source)
        for block in range(3):
            for name in ("P1s", "xs"):
                values = [float(50 * block + place) for place in range(50)]
                server.write(name, [values], [60.0 + 0.5 * (block + 1)])
        time, samples = whole(reader, 300)
    np.testing.assert_array_equal(samples[P1], np.arange(150) * 1e5)
    np.testing.assert_allclose(np.diff(time), 1 / RATE, atol=1e-6)


def test_a_server_that_vanishes_is_found_again(server):
    with opened(server.url) as source:
        reader = connected(source)
        for count in (1, 2):
            for name in NODES:
                server.write(name, [2.0 * count, 3.0 * count], [50 + count, 50.01 + count])
            _, samples = whole(reader, 4 * count)
            server.vanish()
            reader.has(EventKind.DISCONNECTED, times=count)
            server.appear()
            reader.has(EventKind.CONNECTED, times=count + 1)
            time.sleep(0.2)
    assert len(reader.said(EventKind.DISCONNECTED)) == 2
    assert len(reader.said(EventKind.INSECURE)) == 1
    assert samples[P1].tolist() == [2e5, 3e5, 4e5, 6e5]


@pytest.mark.parametrize(("config", "named"), [
    ({"column": "P1", "unit": "bar"}, "P1"), ({"column": "ns=1;s=P1"}, "unit"),
    ({"column": "ns=1;s=P1", "unit": "mm"}, "Pa"),
])  # fmt: skip
def test_a_channel_that_cannot_be_read_is_refused_before_it_is_connected(config, named):
    with pytest.raises(ValueError, match=named):
        OpcUaSource(Address.parse("opc.tcp://127.0.0.1"), FAST, {P1: ChannelConfig(**config)}, RATE)


def test_a_connection_begins_with_the_first_instant_of_all_nodes_but_waits_for_none_that_is_silent(server):
    with opened(server.url) as source:
        reader = connected(source)
        server.write("P1", [1.0, 2.0, 3.0], [70.0, 70.01, 70.02])
        server.write("x", [2.0, 3.0], [70.012, 70.022])
        _, samples = whole(reader, 4)
        np.testing.assert_array_equal(samples[P1], [2e5, 3e5])
        assert not np.isnan(samples[X]).any()
    with opened(server.url) as source:
        reader = connected(source)
        server.write("P1", [1.0, 2.0, 3.0], [80.0, 81.0, 82.1])
        _, samples = whole(reader, 3)
        np.testing.assert_array_equal(samples[P1], [1e5, 2e5, 3e5])


def test_few_items_wait_for_more_and_a_sender_waits_until_there_is_room_or_it_is_closed(monkeypatch):
    monkeypatch.setattr(sources, "GATHER", 60.0)
    inbox = Inbox(20)
    sender = Thread(target=lambda: [inbox.put(number, 10) for number in range(5)])
    sender.start()
    assert inbox.take(60.0, 1000, 20) == [0, 1]
    inbox.close()
    sender.join(60.0)
    assert inbox.take(1.0, 1000) == [2, 3, 4]
    inbox.fail(RuntimeError("fault"))
    with pytest.raises(RuntimeError, match="fault"):
        inbox.take(1.0, 1)
