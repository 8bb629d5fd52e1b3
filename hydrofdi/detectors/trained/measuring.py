"""Scores of windows and statistics of their channels, computed identically for training, judging, streams."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import chain

import numpy as np

from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.detectors.trained.file import ChannelRange
from hydrofdi.errors import Issue
from hydrofdi.indicators import measure
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window


def records_of(
    windows: Sequence[Window], channels: Collection[Channel], sampling_frequency: float
) -> RecordBatch:
    """Windows as a batch of records that start at time 0, without a drive period.

    Parameters
    ----------
    windows : sequence of Window
        At least one; all of equal length, with all channels.
    channels : collection of Channel
    sampling_frequency : float
        Sampling frequency of the detector, not of each window [Hz], so that scores have the same meaning.
    """
    samples = {channel: np.stack([window.channels[channel] for window in windows]) for channel in channels}
    return RecordBatch(samples, sampling_frequency, tuple(str(window.number) for window in windows))


@dataclass(frozen=True)
class Measured:
    """Numbers of windows: bit-identical whatever the other windows are.

    Attributes
    ----------
    numbers : ndarray, shape (n_window, n_number)
        NaN where a window has none.
    obstacles : list of (str or None), length n_window
        Why a window lacks numbers.
    doubts : list of tuple of Issue, length n_window
    fits : mapping of str to ndarray, shape (n_window,)
        Outputs that state how well the model explains a window.
    """

    numbers: Array
    obstacles: list[str | None]
    doubts: list[tuple[Issue, ...]]
    fits: Mapping[str, Array]


def measured_numbers(
    records: RecordBatch, feature: Feature, fits: Mapping[str, float] | None = None
) -> Measured:
    """Measure the numbers of valid windows; `fits` as of `doubts_of`."""
    measures = measure(records, feature.indicators)
    values = {
        prefix + name.partition(".")[2]: array
        for (prefix, _), label in zip(feature.prefixed.items(), feature.indicators, strict=True)
        for name, array in measures.values.items()
        if name.startswith(f"{label}.")
    }
    doubts = [
        doubts_of(
            each, values, prefix, {name.removeprefix(prefix): limit for name, limit in (fits or {}).items()}
        )
        for prefix, each in feature.prefixed.items()
    ]
    own = [each.found_in(measures.values) for each in feature.numbers]
    obstacles = zip(*(measures.obstacles[label] for label in feature.indicators), strict=True)
    return Measured(
        np.stack(own, axis=1),
        [next(filter(None, reasons), None) for reasons in obstacles],
        [tuple(chain.from_iterable(each)) for each in zip(*doubts, strict=True)],
        {name: values[name] for name, output in feature.outputs if output.is_fit},
    )


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            found = "is normalised" if channel in records.normalized else "is in counts"
            return f"{channel} {found}, but a detector needs it in {channel.unit}"
    return None


_TAIL = 0.01
"""Fraction of samples below the low quantile, and above the high one."""

_MARGIN, _OF_SPAN = 0.5, 0.1
"""Margins of a range: fraction of its width, and fraction of the span of the channel. With narrower ranges,
large leaks would be novel and therefore not judged."""

_ACTIVITY = 2.0
"""Factor by which activity may decrease or increase."""

_FEW = 30
"""Number of windows below which margins are doubled, because few windows cover little of the range."""

_PILE, _PILE_LEAST = 2.0, 0.02
"""Factor and offset of the healthy fraction of samples at an end value, above which a window is clipped."""

_COMMANDS = (Channel.INPUT_VOLTAGE, Channel.SPOOL_POSITION)
"""Channels that normally rest at their end values."""


@dataclass(frozen=True)
class ChannelFacts:
    """Statistics of one channel in windows.

    Attributes
    ----------
    low, high : ndarray, shape (n_window,)
        1 % and 99 % quantile, as order statistics.
    activity : ndarray, shape (n_window,)
        RMS difference between adjacent samples.
    at_end : ndarray, shape (n_window,)
        Fraction of samples at the lowest or at the highest value, whichever is larger.
    lowest, highest : ndarray, shape (n_window,)
    is_at_high : ndarray of bool, shape (n_window,)
        Whether that end is the highest value.
    """

    low: Array
    high: Array
    activity: Array
    at_end: Array
    lowest: Array
    highest: Array
    is_at_high: np.ndarray


def channel_facts(samples: Array) -> ChannelFacts:
    """Statistics of a channel in each window, independent of the other windows.

    Parameters
    ----------
    samples : ndarray, shape (n_window, n_time)
    """
    n_time = samples.shape[1]
    rank = int(_TAIL * (n_time - 1))
    ordered = np.partition(samples, (rank, n_time - 1 - rank), axis=1)
    lowest, highest = samples.min(axis=1), samples.max(axis=1)
    at_low, at_high = (np.mean(samples == end[:, None], axis=1) for end in (lowest, highest))
    with np.errstate(over="ignore", invalid="ignore"):
        activity = (
            np.sqrt(np.mean(np.diff(samples, axis=1) ** 2, axis=1)) if n_time > 1 else np.zeros(len(samples))
        )
    return ChannelFacts(
        ordered[:, rank],
        ordered[:, n_time - 1 - rank],
        activity,
        np.maximum(at_low, at_high),
        lowest,
        highest,
        at_high > at_low,
    )


def learned_range(channel: Channel, facts: ChannelFacts) -> ChannelRange:
    """Range of a channel, learned from healthy windows.

    Parameters
    ----------
    channel : Channel
    facts : ChannelFacts
        Statistics of all healthy windows.
    """
    span, wider = float(facts.high.max() - facts.low.min()), 1.0 + _FEW / facts.low.size
    piled, factor = float(facts.at_end.max()), _ACTIVITY**wider
    return ChannelRange(
        low=_widened(facts.low, span, wider),
        high=_widened(facts.high, span, wider),
        activity=(float(facts.activity.min()) / factor, float(facts.activity.max()) * factor),
        at_end=1.0 if channel in _COMMANDS else min(1.0, _PILE * piled + _PILE_LEAST),
    )


def joined(facts: Sequence[ChannelFacts]) -> ChannelFacts:
    """Concatenate statistics of windows."""
    names = [each.name for each in fields(ChannelFacts)]
    return ChannelFacts(*(np.concatenate([getattr(each, name) for each in facts]) for name in names))


def _widened(values: Array, span: float, wider: float) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    margin = wider * (_MARGIN * (high - low) + _OF_SPAN * span)
    return low - margin, high + margin
