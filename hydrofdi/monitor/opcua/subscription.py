"""Changes of nodes, as an OPC UA server sends them."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from math import ceil

from asyncua import ua
from asyncua.client.client import Client
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.uaerrors import UaError

from hydrofdi.errors import ConfigError
from hydrofdi.monitor.opcua.browsing import nearest_nodes
from hydrofdi.monitor.opcua.reasons import LostError, plain_reasons
from hydrofdi.monitor.opcua.session import KEEP_ALIVE, LIFETIME

FIRST_HANDLE = 1
"""Client handle of the first node; for some servers 0 means none."""

_HELD = 10.0
"""What the server should queue in addition to a publishing interval while the network is slow [s]."""

_SILENCE = 4 * KEEP_ALIVE
_UNKNOWN = ("BadNodeIdUnknown", "BadNodeIdInvalid", "BadAttributeIdInvalid")


def node_id(text: str) -> ua.NodeId:
    """The node id that a text states.

    Raises
    ------
    ConfigError
                The text is not a node id.
    """
    try:
        return ua.NodeId.from_string(text)
    except (UaError, ValueError):
        raise ConfigError(
            f"{text!r} is not a node id; write, for example, 'ns=2;s=P1' or 'ns=2;i=1001'"
        ) from None


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
        """Interval at which the server sends messages [s]."""

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
            The server refuses it, has no such node, or is lost.
        """
        with plain_reasons():
            await self._begin(period, publishing_interval)

    async def _begin(self, period: float, publishing_interval: float) -> None:
        self._client.connection_lost_callback = self._results.put
        request = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=1000 * publishing_interval,
            RequestedLifetimeCount=ceil(LIFETIME / publishing_interval),
            RequestedMaxKeepAliveCount=max(1, ceil(KEEP_ALIVE / publishing_interval)),
        )
        created = await self._client.uaclient.create_subscription(request, self._results.put)
        self.publishing_interval = created.RevisedPublishingInterval / 1000
        items = [self._item(position, period) for position in range(len(self._nodes))]
        wanted = ua.CreateMonitoredItemsParameters(created.SubscriptionId, ua.TimestampsToReturn.Both, items)
        results = await self._client.uaclient.create_monitored_items(wanted)
        for node, result in zip(self._nodes, results, strict=True):
            if result.StatusCode.name in _UNKNOWN:
                raise LostError(f"it has no variable {node}{await nearest_nodes(self._client, node)}")
            result.StatusCode.check()
            self.sampling_interval = max(self.sampling_interval, result.RevisedSamplingInterval / 1000)

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
