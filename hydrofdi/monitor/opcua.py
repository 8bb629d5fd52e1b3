"""Values of nodes of an OPC UA server as a stream, which the detector joins; encrypted on request."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from datetime import UTC
from math import ceil
from typing import Any

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

_WAIT = 2.0
"""How long values of nodes wait for a node that has sent none since the connection was made [s]."""

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
        capacity = round(config.queue * sampling_frequency * len(channels))
        self._inbox: sources.Inbox[Chunk] = sources.Inbox(capacity)
        sources.StreamSource.__init__(self, str(address), self._inbox.events)
        super().__init__(self.name, self._inbox.say)
        if not channels:
            raise ConfigError("an OPC UA server needs 'channels': the node of each channel")
        self._config, self._period = config, 1 / sampling_frequency
        self._columns = {channel: _column(channel, config) for channel, config in channels.items()}
        self._nodes = [column.title for column in self._columns.values()]
        self._begun: set[Channel] = set()
        self._early: list[Chunk] | None = []
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
        self._inbox.close()
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
        self._begun.clear()
        self._early = []
        self.report_connected(f", {counted(len(self._nodes), 'node')}")

    def _take(self, changes: Sequence[ua.MonitoredItemNotification]) -> None:
        chunks, n_overflow = [], 0
        for change in changes:
            status = change.Value.StatusCode
            n_overflow += status is not None and status.value & _OVERFLOW == _OVERFLOW
            chunks += self._values(change)
        if n_overflow:
            text = f"{self.name}: its queue was full; samples were lost before they were sent"
            self.say(Event(EventKind.DROPPED, text, count=n_overflow))
        if self._early is not None:
            chunks = self._whole(self._early, chunks)
        if chunks:
            chunk = sources.joined(chunks)
            self._inbox.put(chunk, chunk.n_time)

    def _values(self, change: ua.MonitoredItemNotification) -> list[Chunk]:
        """Values of a change; none for the first of a node, which is an earlier value of any age."""
        channel, column = [*self._columns.items()][change.ClientHandle - _FIRST_HANDLE]
        if channel not in self._begun:
            self._begun.add(channel)
            return []
        try:
            instants, values = _node_values(change.Value, self._period)
        except TypeError as error:
            text = f"{self.name}: {column.title} contains {error} instead of a number"
            self.say(Event(EventKind.MALFORMED, text, is_silent=text in self.said))
            self.said.add(text)
            return []
        return [Chunk(instants, {channel: column.in_si(values)})] if values.size else []

    def _whole(self, early: list[Chunk], chunks: list[Chunk]) -> list[Chunk]:
        """Values from the first instant of all nodes on, which do not begin together. They wait for each
        other, but not for a node that sends nothing."""
        early += chunks
        firsts = {channel: chunk.time[0] for chunk in reversed(early) for channel in chunk.channels}
        begin = max(firsts.values(), default=0.0) - 0.501 * self._period
        if len(firsts) < len(self._nodes) and not any(chunk.time[-1] > begin + _WAIT for chunk in early):
            return []
        self._early = None
        return [chunk.part(int(np.searchsorted(chunk.time, begin)), chunk.n_time) for chunk in early]


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


def _node_values(data: ua.DataValue, period: float) -> tuple[Array, Array]:
    """Instants [s] and values of a number, or of an array of consecutive samples with the time stamp of the
    last; NaN if not good."""
    stamp = data.SourceTimestamp or data.ServerTimestamp
    if stamp is None:
        raise TypeError("a value without a time stamp")
    value = None if data.Value is None else data.Value.Value
    if data.StatusCode is not None and not data.StatusCode.is_good():
        value = math.nan
    numbers = [_number(each) for each in (value if isinstance(value, list) else [value])]
    ages = period * np.arange(len(numbers), dtype=np.float64)[::-1]
    return stamp.replace(tzinfo=UTC).timestamp() - ages, np.array(numbers, dtype=np.float64)


def _number(value: object) -> float:
    if isinstance(value, bool | int | float):
        return float(value) if math.isfinite(value) else math.nan
    raise TypeError("nothing" if value is None else f"a {type(value).__name__}")
