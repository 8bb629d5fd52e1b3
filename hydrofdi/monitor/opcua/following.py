"""A server that is read for as long as the monitor runs, with new connections after losses."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from asyncua import ua

from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.opcua.joining import Joiner, NodeValue
from hydrofdi.monitor.opcua.reasons import LostError, plain_reasons
from hydrofdi.monitor.opcua.session import Server, session
from hydrofdi.monitor.opcua.subscription import FIRST_HANDLE, Subscription, node_id
from hydrofdi.monitor.opcua.values import NoNumberError, changes_of, has_overflowed, node_values
from hydrofdi.records.batch import Array
from hydrofdi.settings.counting import counted

_LONGEST_WAIT = 120.0

_PATIENCE = 3.0
"""Wait before a connection that has not ended is cancelled again [s]; disconnecting takes less."""


class ServerFollower:
    """Follows nodes of a server in an event loop.

    Parameters
    ----------
    server : Server
    nodes : sequence of str
        Node ids.
    period : float
        Sampling period [s].
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.
    put : callable
        Takes instants (n_time,) [s] and samples (n_time, n_node), in the units of the nodes.
    say : callable
        Takes events.

    Raises
    ------
    ConfigError
        A text is not a node id.
    """

    def __init__(
        self,
        server: Server,
        nodes: Sequence[str],
        period: float,
        first_wait: float,
        put: Callable[[Array, Array], None],
        say: Callable[[Event], None],
    ) -> None:
        for node in nodes:
            node_id(node)
        self._server, self._nodes, self._period, self._first_wait = server, nodes, period, first_wait
        self._put, self._say = put, say
        self._joiner = Joiner(len(nodes), period, server.config.wait)
        self._said: set[str] = set()
        self._wrong: set[str] = set()
        self._begun: set[int] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end = asyncio.Event()
        self._is_stopped = False

    async def run(self) -> None:
        """Follow until `stop`."""
        self._loop = asyncio.get_running_loop()
        if self._is_stopped:
            self._end.set()
        following = asyncio.create_task(self._keep_following())
        end = asyncio.create_task(self._end.wait())
        await asyncio.wait((following, end), return_when=asyncio.FIRST_COMPLETED)
        end.cancel()
        while not following.done():  # a library may swallow a cancellation
            following.cancel()
            await asyncio.wait((following,), timeout=_PATIENCE)
        with suppress(asyncio.CancelledError):
            following.result()

    def stop(self) -> None:
        """End; another thread calls this."""
        self._is_stopped = True
        if self._loop is not None and not self._loop.is_closed():
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._end.set)

    async def _keep_following(self) -> None:
        wait = self._first_wait
        while True:
            began = time.monotonic()
            try:
                await self._follow()
            except LostError as error:
                self._lost(str(error))
            except asyncio.CancelledError:
                if self._is_stopped:
                    raise
                self._lost("the connection was lost")
            if time.monotonic() - began > _LONGEST_WAIT:
                wait = self._first_wait
            await asyncio.sleep(wait)
            wait = min(2 * wait, _LONGEST_WAIT)

    async def _follow(self) -> None:
        async with session(self._server) as client:
            subscription = Subscription(client, self._nodes)
            await subscription.begin(self._period, self._server.config.publishing_interval)
            self._joiner.begin()
            self._begun.clear()
            self._found(subscription.sampling_interval, subscription.publishing_interval)
            while True:
                self._take(await subscription.result())

    def _take(self, result: ua.PublishResult) -> None:
        values: list[NodeValue] = []
        now = time.monotonic()
        n_overflow = 0
        with plain_reasons():
            changes = [*changes_of(result)]
        for change in changes:
            n_overflow += has_overflowed(change.Value)
            values += self._values(change, now)
        if n_overflow:
            text = f"{self._server.url}: its queue was full; samples were lost before they were sent"
            self._say(Event(EventKind.DROPPED, text, count=n_overflow))
        self._put(*self._joiner.add(values, now))

    def _values(self, change: ua.MonitoredItemNotification, now: float) -> list[NodeValue]:
        """Values of a change; none for the first of a node, which is an earlier value of any age."""
        position = change.ClientHandle - FIRST_HANDLE
        if position not in self._begun:
            self._begun.add(position)
            return []
        try:
            return node_values(change.Value, position, self._period, now)
        except NoNumberError as error:
            node = self._nodes[position]
            text = f"{self._server.url}: {node} contains {error} instead of a number"
            self._say(Event(EventKind.MALFORMED, text, is_silent=node in self._wrong))
            self._wrong.add(node)
            return []

    def _found(self, sampling_interval: float, publishing_interval: float) -> None:
        """Report a connection. Some servers state the publishing interval even if they sample faster."""
        self._said.clear()
        n_node = len(self._nodes)
        text = f"connected to {self._server.url}, {counted(n_node, 'node')}"
        if sampling_interval > 1.01 * self._period and sampling_interval != publishing_interval:
            text += f"; the server says that it samples every {1000 * sampling_interval:g} ms at best,"
            text += f" the detector needs {1000 * self._period:g} ms"
        self._say(Event(EventKind.CONNECTED, text))

    def _lost(self, reason: str) -> None:
        if reason in self._said:
            return
        self._said.add(reason)
        text = f"{self._server.url} is not read: {reason}; trying again, at least every 2 minutes"
        self._say(Event(EventKind.DISCONNECTED, text))
