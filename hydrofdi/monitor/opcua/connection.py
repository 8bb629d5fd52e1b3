"""One connection to an OPC UA server: session, subscription, messages."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from math import ceil

from asyncua import ua
from asyncua.client.client import Client
from asyncua.crypto import security_policies
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.uaerrors import UaError

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.opcua.configuration import OpcUaConfig
from hydrofdi.monitor.opcua.files import KeyFiles
from hydrofdi.monitor.opcua.reasons import LostError, plain_reasons

logging.getLogger("asyncua").addHandler(logging.NullHandler())

_TIMEOUT = 10.0
_FAREWELL = 2.0
_KEEP_ALIVE = 5.0
_SILENCE = 4 * _KEEP_ALIVE
_LIFETIME = 60.0
_HELD = 10.0
"""What the server shall hold beside a publishing interval while the network is slow [s]."""
FIRST_HANDLE = 1
"""Client handle of the first node; some servers take 0 for none."""


@dataclass(frozen=True)
class Server:
    """What is needed to reach a server.

    Attributes
    ----------
    url : str
    config : OpcUaConfig
    credentials : tuple of (str, str), optional
    files : KeyFiles, optional
        Where the connection is encrypted.
    """

    url: str
    config: OpcUaConfig
    credentials: tuple[str, str] | None
    files: KeyFiles | None


def node_id(text: str) -> ua.NodeId:
    """A node id as it is written.

    Raises
    ------
    ConfigError
        It is none.
    """
    try:
        return ua.NodeId.from_string(text)
    except (UaError, ValueError):
        raise ConfigError(f"{text!r} is no node id; write such as 'ns=2;s=P1' or 'ns=2;i=1001'") from None


@asynccontextmanager
async def session(server: Server) -> AsyncIterator[Client]:
    """A session, which ends with the block.

    Raises
    ------
    LostError
        There is none.
    """
    client = Client(server.url, timeout=_TIMEOUT, watchdog_intervall=_KEEP_ALIVE)
    client.name = client.description = "hydrofdi"
    client.session_timeout = int(1000 * _LIFETIME)
    if server.credentials is not None:
        client.set_user(server.credentials[0])
        client.set_password(server.credentials[1])
    try:
        with plain_reasons():
            if server.files is not None:
                await _encrypt(client, server.config.security, server.files)
            await client.connect()
        yield client
    finally:
        with suppress(Exception):
            await asyncio.wait_for(client.disconnect(), _FAREWELL)
        client.disconnect_socket()


async def _encrypt(client: Client, policy: str, files: KeyFiles) -> None:
    client.application_uri = files.application_uri
    await client.set_security(
        getattr(security_policies, f"SecurityPolicy{policy}"),
        files.certificate,
        files.private_key,
        server_certificate=files.server_certificate,
    )


class Subscription:
    """Changes of nodes, with every time stamp.

    Parameters
    ----------
    client : Client
        A session.
    nodes : sequence of str
        Node ids; changes name them by their client handle.
    """

    def __init__(self, client: Client, nodes: Sequence[str]) -> None:
        self._client, self._nodes = client, nodes
        self._results: asyncio.Queue[ua.PublishResult | Exception] = asyncio.Queue(maxsize=64)
        self.sampling_interval = 0.0
        """Longest interval at which the server samples a node [s]."""
        self.publishing_interval = 0.0
        """How often the server sends what it has [s]."""

    async def begin(self, period: float, publishing_interval: float) -> None:
        """Subscribe.

        Parameters
        ----------
        period : float
            Sampling period [s].
        publishing_interval : float
            [s]

        Raises
        ------
        LostError
            The server refuses it, has no such node, or is gone.
        """
        with plain_reasons():
            await self._begin(period, publishing_interval)

    async def _begin(self, period: float, publishing_interval: float) -> None:
        self._client.connection_lost_callback = self._results.put
        request = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=1000 * publishing_interval,
            RequestedLifetimeCount=ceil(_LIFETIME / publishing_interval),
            RequestedMaxKeepAliveCount=max(1, ceil(_KEEP_ALIVE / publishing_interval)),
        )
        created = await self._client.uaclient.create_subscription(request, self._results.put)
        self.publishing_interval = created.RevisedPublishingInterval / 1000
        items = [self._item(position, period) for position in range(len(self._nodes))]
        wanted = ua.CreateMonitoredItemsParameters(created.SubscriptionId, ua.TimestampsToReturn.Both, items)
        for node, result in zip(
            self._nodes, await self._client.uaclient.create_monitored_items(wanted), strict=True
        ):
            self._check(node, result)

    async def result(self) -> ua.PublishResult:
        """The next message of the server.

        Raises
        ------
        LostError
            The connection is lost, or the server is silent.
        """
        with plain_reasons():
            result = await asyncio.wait_for(self._results.get(), _SILENCE)
            if isinstance(result, Exception):
                raise result
            return result

    def _item(self, position: int, period: float) -> ua.MonitoredItemCreateRequest:
        every_stamp = ua.DataChangeFilter(Trigger=ua.DataChangeTrigger.StatusValueTimestamp)
        parameters = ua.MonitoringParameters(
            ClientHandle=position + FIRST_HANDLE,
            SamplingInterval=1000 * period,
            Filter=every_stamp,
            QueueSize=ceil((self.publishing_interval + _HELD) / period),
            DiscardOldest=True,
        )
        read = ua.ReadValueId(node_id(self._nodes[position]), AttributeIds.Value)
        return ua.MonitoredItemCreateRequest(read, ua.MonitoringMode.Reporting, parameters)

    def _check(self, node: str, result: ua.MonitoredItemCreateResult) -> None:
        if result.StatusCode.name in ("BadNodeIdUnknown", "BadNodeIdInvalid", "BadAttributeIdInvalid"):
            raise LostError(f"it has no variable {node}")
        result.StatusCode.check()
        self.sampling_interval = max(self.sampling_interval, result.RevisedSamplingInterval / 1000)
