"""A stream from an OPC UA server: subscribed nodes, joined by their time stamps; encrypted on request."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from asyncua import ua
from asyncua.client.client import Client
from asyncua.crypto import security_policies
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.uaerrors import UaError, UaStatusCodeError
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding, load_der_private_key, load_pem_private_key

from hydrofdi.errors import ConfigError
from hydrofdi.monitor import sources
from hydrofdi.monitor.configuration import Address, OpcUaConfig
from hydrofdi.records import Array, Channel
from hydrofdi.records.columns import ReadColumn, factor_to_si
from hydrofdi.records.description import ChannelConfig
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.settings.messages import counted

logging.getLogger("asyncua").addHandler(logging.NullHandler())

_FIRST_HANDLE = 1
"""Client handle of the first node; for some servers 0 means none."""

_LIFETIME, _KEEP_ALIVE = 60.0, 5.0
"""How long the server keeps a lost session, as it has few; interval of signs of life on both sides [s]."""

_HELD = 10.0
"""What the server should queue in addition to a publishing interval while the network is slow [s]."""

_TIMEOUT, _FAREWELL, _SILENCE = 10.0, 2.0, 4 * _KEEP_ALIVE
_POLL, _PATIENCE = 0.1, 3.0
"""Time between looks whether to end; wait before a connection that has not ended is cancelled again [s]."""

_MOST = 65_536
"""Most samples that are read at once."""

_OVERFLOW = 0x480
"""Bits of the status of a value before which the queue of the server was full."""


class OpcUaSource(sources.Connection, sources.StreamSource):
    """Nodes of an OPC UA server."""

    def __init__(
        self,
        address: Address,
        config: OpcUaConfig,
        channels: Mapping[Channel, ChannelConfig],
        sampling_frequency: float,
    ) -> None:
        self._inbox: sources.Inbox[Chunk] = sources.Inbox(max(2, round(config.queue * sampling_frequency)))
        sources.StreamSource.__init__(self, str(address), self._inbox.events)
        super().__init__(self.name, self._inbox.say)
        if not channels:
            raise ConfigError("an OPC UA server needs 'channels': the node of each channel")
        self._config, self._period = config, 1 / sampling_frequency
        self._columns = {channel: _column(channel, config) for channel, config in channels.items()}
        self._nodes = [column.title for column in self._columns.values()]
        self._joiner = Joiner(len(self._nodes), self._period, config.wait)
        self._begun: set[int] = set()
        self._new_client()

    def open(self, position: sources.Position) -> None:
        """Begin to connect; keep trying if the server does not answer."""
        self.begin(self._doubts())

    def read(self, timeout: float) -> Chunk | None:
        """New samples."""
        chunks = self._inbox.take(timeout, _MOST)
        return sources.joined(chunks) if chunks else None

    def close(self) -> None:
        """End the connection and its thread."""
        self.end()

    def connect_once(self) -> str:
        """Connect in an event loop of its own."""
        return asyncio.run(self._until_closed())

    def _doubts(self) -> Iterator[str]:
        yield from sources.exposed(self._config.password_file, self._config.key)
        if self._config.security == "none":
            yield f"{self.name} is not encrypted, and not checked; see 'opcua.security'"

    async def _until_closed(self) -> str:
        following = asyncio.create_task(self._follow())
        while not following.done():
            await asyncio.wait((following,), timeout=_POLL)
            if self.is_closing.is_set():  # again and again: a library may swallow a cancellation
                following.cancel()
                await asyncio.wait((following,), timeout=_PATIENCE)
        with suppress(asyncio.CancelledError):
            return following.result()
        return "the connection was lost"

    async def _follow(self) -> str:
        """Take what the server sends; afterwards, why it sends no more."""
        results: asyncio.Queue[ua.PublishResult | Exception] = asyncio.Queue(maxsize=64)
        try:
            async with self._session() as client:
                client.connection_lost_callback = results.put
                await self._subscribe(client, results)
                while True:
                    result = await asyncio.wait_for(results.get(), _SILENCE)
                    if isinstance(result, Exception):
                        raise result
                    changes = _changes_of(result)
                    try:
                        self._take(changes)
                    except Exception as failure:
                        self._inbox.fail(failure)
                        raise
        except Exception as error:  # whatever the library raises is a reason to try again
            return _reason(error)

    @asynccontextmanager
    async def _session(self) -> AsyncIterator[Client]:
        client, expected = self._new_client()
        try:
            if expected:
                await self._check(client, expected)
            await client.connect()
            yield client
        finally:
            with suppress(Exception):
                await asyncio.wait_for(client.disconnect(), _FAREWELL)
            client.disconnect_socket()

    def _new_client(self) -> tuple[Client, bytes]:
        """A client, and the certificate of the server if it is checked; files are read anew each time."""
        config, client = self._config, Client(self.name, timeout=_TIMEOUT, watchdog_intervall=_KEEP_ALIVE)
        client.name = client.description = "hydrofdi"
        client.session_timeout = int(1000 * _LIFETIME)
        user, password = sources.credentials("opcua", config.username, config.password_file)
        if user and not password:
            raise ConfigError("opcua.password_file: is missing; there is a user without a password")
        if password and config.security == "none":
            raise ConfigError("opcua.security: none would send the password unencrypted; choose a policy")
        if user:
            client.set_user(user)
            client.set_password(password)
        if config.security == "none":
            return client, b""
        own, server, key = (_loaded(name, config) for name in ("certificate", "server_certificate", "key"))
        with sources.usable("opcua.certificate", config.certificate):
            names = own.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
            client.application_uri = names.get_values_for_type(x509.UniformResourceIdentifier)[0]
            if key.public_key() != own.public_key():
                raise ValueError
        policy = getattr(security_policies, f"SecurityPolicy{config.security}")
        client.security_policy = policy(server, own, key, ua.MessageSecurityMode.SignAndEncrypt)
        client.uaclient.set_security(client.security_policy)
        return client, server.public_bytes(Encoding.DER)

    async def _check(self, client: Client, expected: bytes) -> None:
        """Check policy and certificate: a server does not answer what is encrypted for another one."""
        wanted = client.security_policy.URI, ua.MessageSecurityMode.SignAndEncrypt
        for endpoint in await Client(self.name, timeout=_TIMEOUT).connect_and_get_server_endpoints():
            is_own = (endpoint.ServerCertificate or b"").startswith(expected)
            if is_own and (endpoint.SecurityPolicyUri, endpoint.SecurityMode) == wanted:
                return
        raise ConnectionError("it does not offer 'security' with signing and 'server_certificate'")

    async def _subscribe(self, client: Client, results: asyncio.Queue[ua.PublishResult | Exception]) -> None:
        """Subscribe to all nodes."""
        interval = self._config.publishing_interval
        request = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=1000 * interval,
            RequestedLifetimeCount=ceil(_LIFETIME / interval),
            RequestedMaxKeepAliveCount=max(1, ceil(_KEEP_ALIVE / interval)),
        )
        created = await client.uaclient.create_subscription(request, results.put)
        n_queued = ceil((created.RevisedPublishingInterval / 1000 + _HELD) / self._period)
        items = [
            ua.MonitoredItemCreateRequest(
                ua.ReadValueId(ua.NodeId.from_string(node), AttributeIds.Value),
                ua.MonitoringMode.Reporting,
                ua.MonitoringParameters(
                    ClientHandle=handle,
                    SamplingInterval=1000 * self._period,
                    Filter=ua.DataChangeFilter(Trigger=ua.DataChangeTrigger.StatusValueTimestamp),
                    QueueSize=n_queued,
                    DiscardOldest=True,
                ),
            )
            for handle, node in enumerate(self._nodes, _FIRST_HANDLE)
        ]
        wanted = ua.CreateMonitoredItemsParameters(created.SubscriptionId, ua.TimestampsToReturn.Both, items)
        for node, item in zip(self._nodes, await client.uaclient.create_monitored_items(wanted), strict=True):
            if not item.StatusCode.is_good():
                raise ConnectionError(f"it does not report {node}: {item.StatusCode.name}")
        self._joiner.begin()
        self._begun.clear()
        self.report_connected(f", {counted(len(self._nodes), 'node')}")

    def _take(self, changes: Sequence[ua.MonitoredItemNotification]) -> None:
        now, n_overflow = time.monotonic(), 0
        values: list[NodeValue] = []
        for change in changes:
            status = change.Value.StatusCode
            n_overflow += status is not None and status.value & _OVERFLOW == _OVERFLOW
            values += self._values(change, now)
        if n_overflow:
            text = f"{self.name}: its queue was full; samples were lost before they were sent"
            self.say(Event(EventKind.DROPPED, text, count=n_overflow))
        instants, samples = self._joiner.add(values, now)
        if instants.size:
            columns = zip(self._columns.items(), samples.T, strict=True)
            chunk = Chunk(instants, {channel: column.in_si(row.copy()) for (channel, column), row in columns})
            self._inbox.put(chunk, chunk.n_time, count=chunk.n_time, time=float(instants[0]))

    def _values(self, change: ua.MonitoredItemNotification, now: float) -> list[NodeValue]:
        """Values of a change; none for the first of a node, which is an earlier value of any age."""
        position = change.ClientHandle - _FIRST_HANDLE
        if position not in self._begun:
            self._begun.add(position)
            return []
        try:
            return _node_values(change.Value, position, self._period, now)
        except TypeError as error:
            text = f"{self.name}: {self._nodes[position]} contains {error} instead of a number"
            self.say(Event(EventKind.MALFORMED, text, is_silent=text in self.said))
            self.said.add(text)
            return []


def _changes_of(result: ua.PublishResult) -> list[ua.MonitoredItemNotification]:
    changes: list[ua.MonitoredItemNotification] = []
    for data in result.NotificationMessage.NotificationData or ():
        if isinstance(data, ua.DataChangeNotification):
            changes += data.MonitoredItems
        elif isinstance(data, ua.StatusChangeNotification):
            data.Status.check()
    return changes


def _reason(error: Exception) -> str:
    if isinstance(error, UaStatusCodeError):
        status = ua.StatusCode(error.code)
        return f"{status.doc.rstrip('.')} ({status.name})"
    if isinstance(error, OSError):
        return sources.network_reason(error)
    return f"{' '.join(str(error).split())} ({type(error).__name__})"


def _loaded(key: str, config: OpcUaConfig) -> Any:
    """The certificate or the private key of a setting, in PEM or DER."""
    path = getattr(config, key)
    with sources.usable(f"opcua.{key}", path):
        content = path.read_bytes()
        is_pem = b"-----BEGIN" in content
        if key == "key":
            return (load_pem_private_key if is_pem else load_der_private_key)(content, None)
        return (x509.load_pem_x509_certificate if is_pem else x509.load_der_x509_certificate)(content)


def _column(channel: Channel, config: ChannelConfig) -> ReadColumn:
    where = f"channels.{channel}"
    try:
        ua.NodeId.from_string(config.column)
    except (UaError, ValueError):
        raise ConfigError(f"{where}: {config.column!r} is not a node id such as 'ns=2;s=P1'") from None
    if not config.unit:
        raise ConfigError(f"{where}: write the 'unit' of the node, such as bar")
    return ReadColumn(0, config.column, config, config.unit, factor_to_si(config.unit, channel.unit, where))


def _node_values(data: ua.DataValue, channel: int, period: float, arrival: float) -> list[NodeValue]:
    """A number, or an array of consecutive samples with the time stamp of the last; NaN if not good."""
    stamp = data.SourceTimestamp or data.ServerTimestamp
    if stamp is None:
        raise TypeError("a value without a time stamp")
    value = None if data.Value is None else data.Value.Value
    if data.StatusCode is not None and not data.StatusCode.is_good():
        value = math.nan
    numbers = value if isinstance(value, list) else [value]
    end = stamp.replace(tzinfo=UTC).timestamp()
    start = end - (len(numbers) - 1) * period
    return [NodeValue(start + n * period, channel, _number(x), arrival) for n, x in enumerate(numbers)]


def _number(value: object) -> float:
    if isinstance(value, bool | int | float):
        return float(value) if math.isfinite(value) else math.nan
    raise TypeError("nothing" if value is None else f"a {type(value).__name__}")


class NodeValue(NamedTuple):
    """A value of one node: instant [s], position of its channel, value in its unit, when it arrived [s]."""

    time: float
    channel: int
    value: float
    arrival: float


class Joiner:
    """Joins values whose time stamps lie within half a sampling period.

    If a node has no value for an instant, the sample is NaN. The instant is complete without it as soon as
    the node has sent a later value, or after `wait` seconds. Before the first instant with all nodes, up to
    `wait` seconds of other instants are dropped, because nodes do not begin together.
    """

    def __init__(self, n_channel: int, period: float, wait: float) -> None:
        self._n_channel, self._tolerance, self._wait = n_channel, 0.501 * period, wait
        self._patience = round(wait / period)
        self._last = -np.inf
        self.begin()

    def begin(self) -> None:
        """Begin a new connection; pending values of the old one are dropped."""
        self._pending: list[NodeValue] = []
        self._latest = [-np.inf] * self._n_channel
        self._left_out = 0

    def add(self, values: Sequence[NodeValue], now: float) -> tuple[Array, Array]:
        """Add values, those of a node in the order in which it sent them, and return the ready samples."""
        for value in values:
            self._latest[value.channel] = value.time
        self._pending = sorted((*self._pending, *values))
        instants = self._instants()
        n_ready = 0
        while n_ready < len(instants) and self._is_ready(*instants[n_ready], now):
            n_ready += 1
        self._pending = [value for _, values in instants[n_ready:] for value in values.values()]
        kept = [instant for instant in instants[:n_ready] if self._is_kept(*instant)]
        samples = np.full((len(kept), self._n_channel), np.nan)
        for row, (_, present) in enumerate(kept):
            for value in present.values():
                samples[row, value.channel] = value.value
        return np.array([time for time, _ in kept]), samples

    def _instants(self) -> list[tuple[float, dict[int, NodeValue]]]:
        """Instants, each with the values of its channels: at most one of a node."""
        instants: list[tuple[float, dict[int, NodeValue]]] = []
        for value in self._pending:
            begin, values = instants[-1] if instants else (-np.inf, {})
            is_other = value.channel in values and values[value.channel].time != value.time
            if value.time - begin > self._tolerance or is_other:
                values = {}
                instants.append((value.time, values))
            values[value.channel] = value
        return instants

    def _is_ready(self, time: float, values: Mapping[int, NodeValue], now: float) -> bool:
        missing = set(range(self._n_channel)) - values.keys()
        if all(self._latest[channel] - time > self._tolerance for channel in missing):
            return True
        return now - min(value.arrival for value in values.values()) > self._wait

    def _is_kept(self, time: float, values: Mapping[int, NodeValue]) -> bool:
        if len(values) == self._n_channel:
            self._left_out = self._patience
        elif time <= self._last + self._tolerance:
            return False
        elif self._left_out < self._patience:
            self._left_out += 1
            return False
        self._last = time
        return True
