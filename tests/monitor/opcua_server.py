"""An OPC UA server on loopback, in a thread of the tests."""

import asyncio
import socket
from datetime import UTC, datetime, timedelta
from threading import Thread

from asyncua import Server, ua

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


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
        for value, time, status in samples:
            held = value if isinstance(value, ua.Variant) else ua.Variant(value)
            stamp = EPOCH + timedelta(seconds=time)
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
