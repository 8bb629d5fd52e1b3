"""Records that differ from the others of their group."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array, RejectedRecord
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.forming import MeasuredRecord

_FEWEST = 8
"""Fewest records of a group that is checked."""
_TO_DEVIATION = 1.4826
"""Standard deviation of normal numbers over their median absolute deviation."""

Key = tuple[str, Channel]
"""Group and channel."""


def outliers(
    records: Iterable[MeasuredRecord | RejectedRecord], limit: float
) -> dict[str, tuple[Issue, ...]]:
    """Record id → remarks, for records that are further from the median of their group than others.

    The check compares the stroke, and the logarithm of the RMS of each pressure's changes from sample to
    sample.

    Parameters
    ----------
    records : iterable of MeasuredRecord or RejectedRecord
        Only a few numbers of each are kept.
    limit : float
        Largest usual distance from the median, in robust standard deviations.
    """
    names: dict[Key, list[str]] = defaultdict(list)
    numbers: dict[Key, list[float]] = defaultdict(list)
    for record in records:
        if isinstance(record, MeasuredRecord):
            for channel, number in _looked_at(record).items():
                names[record.group, channel].append(record.record_id)
                numbers[record.group, channel].append(number)
    found: dict[str, tuple[Issue, ...]] = defaultdict(tuple)
    for key, values in numbers.items():
        distances = _distances(np.array(values))
        for row in np.flatnonzero(distances > limit).tolist():
            found[names[key][row]] += (_remark(key[1], float(distances[row])),)
    return found


def _looked_at(record: MeasuredRecord) -> dict[Channel, float]:
    channels = record.recording.channels
    numbers = {Channel.PISTON_POSITION: record.stroke} if Channel.PISTON_POSITION in channels else {}
    for channel, samples in channels.items():
        if channel.is_pressure:
            change = float(np.sqrt(np.mean(np.diff(samples) ** 2)))
            numbers[channel] = float(np.log(change)) if change > 0.0 else np.nan
    return numbers


def _distances(values: Array) -> Array:
    """Distances from the median in robust standard deviations; zero if there are few values."""
    finite = values[np.isfinite(values)]
    if finite.size < _FEWEST:
        return np.zeros(values.size)
    middle = np.median(finite)
    spread = _TO_DEVIATION * float(np.median(np.abs(finite - middle)))
    away = np.nan_to_num(np.abs(values - middle))
    return np.asarray(np.divide(away, spread, out=np.zeros(values.size), where=spread > 0.0))


def _remark(channel: Channel, distance: float) -> Issue:
    what = "the stroke is" if channel is Channel.PISTON_POSITION else f"the changes of {channel} are"
    text = f"{what} {distance:.1f} standard deviations from the median of its group"
    return Issue(text, channel, kind="outlier")
