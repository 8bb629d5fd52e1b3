"""Values in the notifications of an OPC UA server."""

from __future__ import annotations

import math
from collections.abc import Iterator
from datetime import UTC, datetime

from asyncua import ua

from hydrofdi.monitor.opcua.joining import NodeValue

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class NoNumberError(Exception):
    """A node contains something other than a number, or an array of numbers, with a time stamp."""


def node_values(data: ua.DataValue, channel: int, period: float, arrival: float) -> list[NodeValue]:
    """Values of a notification; NaN if the status is not good.

    Parameters
    ----------
    data : DataValue
        A number, or an array of consecutive samples with the time stamp of the last.
    channel : int
        Position of the channel.
    period : float
        Sampling period [s].
    arrival : float
        Instant of arrival [s].

    Raises
    ------
    NoNumberError
        It contains something else.
    """
    stamp = data.SourceTimestamp or data.ServerTimestamp
    if stamp is None:
        raise NoNumberError("a value without a time stamp")
    end = _seconds(stamp)
    if data.StatusCode is not None and not data.StatusCode.is_good():
        return [NodeValue(end, channel, math.nan, arrival)]
    held = None if data.Value is None else data.Value.Value
    if not isinstance(held, list):
        return [NodeValue(end, channel, _number(held), arrival)]
    start = end - (len(held) - 1) * period
    return [NodeValue(start + i * period, channel, _number(each), arrival) for i, each in enumerate(held)]


def has_overflowed(data: ua.DataValue) -> bool:
    """Whether the server's queue was full before this value."""
    overflow = 0x480
    return data.StatusCode is not None and data.StatusCode.value & overflow == overflow


def changes_of(result: ua.PublishResult) -> Iterator[ua.MonitoredItemNotification]:
    """Changes in a message of the server.

    Raises
    ------
    UaStatusCodeError
        The subscription has ended.
    """
    for data in result.NotificationMessage.NotificationData or ():
        if isinstance(data, ua.DataChangeNotification):
            yield from data.MonitoredItems
        elif isinstance(data, ua.StatusChangeNotification):
            data.Status.check()


def _seconds(stamp: datetime) -> float:
    """Time since 1970, in UTC [s]."""
    return (stamp.replace(tzinfo=UTC) - _EPOCH).total_seconds()


def _number(held: object) -> float:
    if isinstance(held, bool | int | float):
        return float(held) if math.isfinite(held) else math.nan
    raise NoNumberError("nothing" if held is None else f"a {type(held).__name__}")
