"""An OPC UA server on loopback, in a thread of the tests."""

import asyncio
import time
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from threading import Thread

import numpy as np
from asyncua import Server, ua

from hydrofdi.monitor.configuration import Address, OpcUaConfig
from hydrofdi.monitor.opcua import OpcUaSource
from hydrofdi.records.batch import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.records.streams import EventKind
from tests.monitor.brokers import free_port
from tests.monitor.streams import reading_of

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)


class LoopbackServer:
    """Variables ``ns=1;s=NAME``, written from the test with time stamps of its own."""

    def __init__(
        self,
        initial,
        port=None,
        set_up=None,
        user_manager=None,
    ):
        self.port = port or free_port()
        self.url = f"opc.tcp://127.0.0.1:{self.port}/plant"
        self._initial, self._set_up, self._user_manager = initial, set_up, user_manager
        self._is_running = False
        self._loop = asyncio.new_event_loop()
        self._thread = Thread(target=self._loop.run_forever)

    def __enter__(self):
        self._thread.start()
        try:
            self.do(self._start())
        except BaseException:
            self._end()
            raise
        self._is_running = True
        return self

    def __exit__(self, *_):
        if self._is_running:
            self.stop()

    def stop(self):
        self._is_running = False
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
        self.do(self._write(name, list(zip(values, times, statuses, strict=True))))

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

    async def _write(self, name, samples):
        for value, instant, status in samples:
            held = value if isinstance(value, ua.Variant) else ua.Variant(value)
            stamp = EPOCH + timedelta(seconds=instant)
            data = ua.DataValue(held, ua.StatusCode(status), SourceTimestamp=stamp)
            await self._server.write_attribute_value(self._nodes[name].nodeid, data)

    async def _cancel_leftovers(self):
        """Tasks that the server does not end by itself."""
        left = asyncio.all_tasks() - {asyncio.current_task()}
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)

    def _end(self):
        self.do(self._cancel_leftovers())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


P1, X = Channel.CHAMBER_1_PRESSURE, Channel.PISTON_POSITION
CHANNELS = {
    P1: ChannelConfig(column="ns=1;s=P1", unit="bar"),
    X: ChannelConfig(column="ns=1;s=x", unit="mm", gain=2.0, offset=1.0, sign=-1),
}
NODES = {"P1": 0.0, "x": 0.0}
FAST = OpcUaConfig(publishing_interval=0.05, wait=0.5)
RATE = 100.0


@contextmanager
def opened(url, config=FAST, channels=CHANNELS, rate=RATE):
    source = OpcUaSource(Address.parse(url), config, channels, rate, first_wait=0.1)
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
            chunk, events, _ = reading_of(self._source, 0.2)
            self.chunks += [chunk] if chunk else []
            self.events += events
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
