"""A stream from an OPC UA server: subscribed nodes, joined by their time stamps."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Mapping, Sequence
from contextlib import aclosing, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from threading import Thread
from typing import NamedTuple

import numpy as np
from asyncua import ua

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.configuration import OpcUaConfig, server_url
from hydrofdi.monitor.lines import Event, EventKind
from hydrofdi.monitor.opcua.session import FIRST_HANDLE, Changes, LostError, Server, node_id
from hydrofdi.monitor.security import exposed
from hydrofdi.monitor.sources.contract import Inbox, Position, Reading, StreamSource, joined
from hydrofdi.records.batch import Array, Channel
from hydrofdi.records.measured.columns import Column, factor_to_si
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.messages import counted

_LONGEST_WAIT = 120.0

_PATIENCE = 3.0
"""Wait before a connection that has not ended is cancelled again [s]; disconnecting takes less."""

_MOST = 65_536
"""Most samples of a reading."""

_OVERFLOW = 0x480
"""Bits of the status of a value before which the queue of the server was full."""

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class OpcUaSource(StreamSource):
    """Nodes of an OPC UA server.

    Parameters
    ----------
    url : str
        ``opc.tcp://host:port/path``.
    config : OpcUaConfig
    channels : mapping of Channel to ChannelConfig
        `column` is the node id; the unit must be stated.
    sampling_frequency : float
        Sampling frequency of the detector [Hz].
    first_wait : float
        Wait before the second attempt to connect [s]; it doubles up to two minutes.

    Raises
    ------
    ConfigError
        Address, nodes, units, files or credentials cannot be used.
    """

    def __init__(
        self,
        url: str,
        config: OpcUaConfig,
        channels: Mapping[Channel, ChannelConfig],
        sampling_frequency: float,
        *,
        first_wait: float = 1.0,
    ) -> None:
        self._name = server_url(url)
        if not channels:
            raise ConfigError("an OPC UA server needs 'channels': the node of each channel")
        self._columns = {channel: _column(channel, each) for channel, each in channels.items()}
        self._nodes = [column.title for column in self._columns.values()]
        self._server, self._first_wait = Server(self._name, config), first_wait
        self._period = 1 / sampling_frequency
        self._inbox: Inbox[Chunk] = Inbox(max(2, round(config.queue * sampling_frequency)))
        self._joiner = Joiner(len(self._nodes), self._period, config.wait)
        self._said: set[str] = set()
        self._begun: set[int] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end = asyncio.Event()
        self._is_stopped = False
        self._thread = Thread(target=self._run, name="opcua", daemon=True)

    @property
    def name(self) -> str:
        """The address."""
        return self._name

    def open(self, position: Position) -> None:
        """Begin to connect; keep trying if the server does not answer."""
        config = self._server.config
        doubts = [*exposed(config.password_file, config.key)]
        if config.security == "none":
            doubts.append(f"{self._name} is not encrypted, and not checked; see 'opcua.security'")
        for doubt in doubts:
            self._inbox.say(Event(EventKind.INSECURE, doubt))
        self._thread.start()

    def read(self, timeout: float) -> Reading:
        """New samples and events."""
        chunks, events = self._inbox.take(timeout, _MOST)
        return Reading(joined(chunks) if chunks else None, tuple(events))

    def close(self) -> None:
        """End the connection and its thread."""
        self._is_stopped = True
        if self._loop is not None and not self._loop.is_closed():
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._end.set)
        if self._thread.is_alive():
            self._thread.join()

    def _run(self) -> None:
        try:
            asyncio.run(self._until_stopped())
        except Exception as failure:
            self._inbox.fail(failure)

    async def _until_stopped(self) -> None:
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
        changes = self._server.changes(self._nodes, self._period, self._connected)
        async with aclosing(changes) as following:
            async for some in following:
                self._take(some)

    def _take(self, changes: Changes) -> None:
        now, n_overflow = time.monotonic(), 0
        values: list[NodeValue] = []
        for change in changes:
            status = change.Value.StatusCode
            n_overflow += status is not None and status.value & _OVERFLOW == _OVERFLOW
            values += self._values(change, now)
        if n_overflow:
            text = f"{self._name}: its queue was full; samples were lost before they were sent"
            self._inbox.say(Event(EventKind.DROPPED, text, count=n_overflow))
        instants, samples = self._joiner.add(values, now)
        if instants.size:
            columns = zip(self._columns.items(), samples.T, strict=True)
            chunk = Chunk(instants, {channel: column.in_si(row.copy()) for (channel, column), row in columns})
            self._inbox.put(chunk, chunk.n_time, count=chunk.n_time, time=float(instants[0]))

    def _values(self, change: ua.MonitoredItemNotification, now: float) -> list[NodeValue]:
        """Values of a change; none for the first of a node, which is an earlier value of any age."""
        position = change.ClientHandle - FIRST_HANDLE
        if position not in self._begun:
            self._begun.add(position)
            return []
        try:
            return _node_values(change.Value, position, self._period, now)
        except TypeError as error:
            text = f"{self._name}: {self._nodes[position]} contains {error} instead of a number"
            self._inbox.say(Event(EventKind.MALFORMED, text, is_silent=text in self._said))
            self._said.add(text)
            return []

    def _connected(self, sampled: float, published: float) -> None:
        """Report a connection. Some servers state the publishing interval even if they sample faster."""
        self._joiner.begin()
        self._begun.clear()
        self._said.clear()
        text = f"connected to {self._name}, {counted(len(self._nodes), 'node')}"
        if sampled > 1.01 * self._period and sampled != published:
            text += f"; the server says that it samples every {1000 * sampled:g} ms at best,"
            text += f" the detector needs {1000 * self._period:g} ms"
        self._inbox.say(Event(EventKind.CONNECTED, text))

    def _lost(self, reason: str) -> None:
        if reason not in self._said:
            self._said.add(reason)
            text = f"{self._name} is not read: {reason}; trying again, at least every 2 minutes"
            self._inbox.say(Event(EventKind.DISCONNECTED, text))


def _column(channel: Channel, config: ChannelConfig) -> Column:
    where = f"channels.{channel}"
    node_id(config.column)
    if not config.unit:
        raise ConfigError(f"{where}: write the 'unit' of the node, such as bar")
    return Column(0, config.column, config, config.unit, factor_to_si(config.unit, channel.unit, where))


def _node_values(data: ua.DataValue, channel: int, period: float, arrival: float) -> list[NodeValue]:
    """A number, or an array of consecutive samples with the time stamp of the last; NaN if not good."""
    stamp = data.SourceTimestamp or data.ServerTimestamp
    if stamp is None:
        raise TypeError("a value without a time stamp")
    end = _seconds(stamp)
    held = None if data.Value is None else data.Value.Value
    if data.StatusCode is not None and not data.StatusCode.is_good():
        held = math.nan
    numbers = held if isinstance(held, list) else [held]
    start = end - (len(numbers) - 1) * period
    return [NodeValue(start + n * period, channel, _number(each), arrival) for n, each in enumerate(numbers)]


def _seconds(stamp: datetime) -> float:
    """Time since 1970, in UTC [s]."""
    return (stamp.replace(tzinfo=UTC) - _EPOCH).total_seconds()


def _number(held: object) -> float:
    if isinstance(held, bool | int | float):
        return float(held) if math.isfinite(held) else math.nan
    raise TypeError("nothing" if held is None else f"a {type(held).__name__}")


class NodeValue(NamedTuple):
    """A value of one node: instant [s], position of its channel, value in its unit, when it arrived [s]."""

    time: float
    channel: int
    value: float
    arrival: float


@dataclass
class _Instant:
    time: float
    values: dict[int, NodeValue]


class Joiner:
    """Joins values whose time stamps lie within half a sampling period.

    If a node has no value for an instant, the sample is NaN. The instant is complete without it as soon as
    the node has sent a later value, or after `wait` seconds. Before the first instant with all nodes, up to
    `wait` seconds of other instants are dropped, because nodes do not begin together.

    Parameters
    ----------
    n_channel : int
    period : float
        Sampling period [s].
    wait : float
        [s]
    """

    def __init__(self, n_channel: int, period: float, wait: float) -> None:
        self._n_channel, self._tolerance, self._wait = n_channel, period / 2, wait
        self._patience = round(wait / period)
        self._last = -np.inf
        self.begin()

    def begin(self) -> None:
        """Begin a new connection; pending values of the old one are dropped."""
        self._pending: list[NodeValue] = []
        self._latest = [-np.inf] * self._n_channel
        self._left_out = 0

    def add(self, values: Sequence[NodeValue], now: float) -> tuple[Array, Array]:
        """Add values, those of a node in the order in which it sent them, and return the ready samples.

        Parameters
        ----------
        values : sequence of NodeValue
        now : float
            Present instant on the clock of `arrival` [s].

        Returns
        -------
        time : ndarray, shape (n_time,)
            Instants that have all nodes, or have waited long enough [s].
        samples : ndarray, shape (n_time, n_channel)
            In the units of the nodes; NaN if a node has no value.
        """
        for value in values:
            self._latest[value.channel] = value.time
        self._pending = sorted((*self._pending, *values))
        instants = self._instants()
        n_ready = 0
        while n_ready < len(instants) and self._is_ready(instants[n_ready], now):
            n_ready += 1
        self._pending = [value for instant in instants[n_ready:] for value in instant.values.values()]
        kept = [instant for instant in instants[:n_ready] if self._is_kept(instant)]
        samples = np.full((len(kept), self._n_channel), np.nan)
        for row, instant in enumerate(kept):
            for value in instant.values.values():
                samples[row, value.channel] = value.value
        return np.array([instant.time for instant in kept]), samples

    def _instants(self) -> list[_Instant]:
        instants: list[_Instant] = []
        for value in self._pending:
            here = instants[-1] if instants else None
            if here is None or value.time - here.time > self._tolerance or _differs(here, value):
                here = _Instant(value.time, {})
                instants.append(here)
            here.values[value.channel] = value
        return instants

    def _is_ready(self, instant: _Instant, now: float) -> bool:
        missing = set(range(self._n_channel)) - instant.values.keys()
        if all(self._latest[channel] - instant.time > self._tolerance for channel in missing):
            return True
        return now - min(value.arrival for value in instant.values.values()) > self._wait

    def _is_kept(self, instant: _Instant) -> bool:
        if len(instant.values) == self._n_channel:
            self._left_out = self._patience
        elif instant.time <= self._last + self._tolerance:
            return False
        elif self._left_out < self._patience:
            self._left_out += 1
            return False
        self._last = instant.time
        return True


def _differs(instant: _Instant, value: NodeValue) -> bool:
    """Whether the instant has another value of the node, from another time."""
    other = instant.values.get(value.channel)
    return other is not None and other.time != value.time
