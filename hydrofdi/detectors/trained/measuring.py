"""Numbers of windows, computed identically for training, judging, streams; healthy ranges; verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from hydrofdi.detectors.trained.conditions import TEMPERATURE, conditions_of, outside
from hydrofdi.detectors.trained.configuration import Feature
from hydrofdi.detectors.trained.file import ChannelRange, DetectorFile
from hydrofdi.errors import Issue
from hydrofdi.evaluation.scores import comparable
from hydrofdi.indicators import measure
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window
from hydrofdi.settings.readable import shown_quantity


def records_of(
    windows: Sequence[Window], channels: Collection[Channel], sampling_frequency: float
) -> RecordBatch:
    """Windows as a batch of records that start at time 0, without a drive period.

    Parameters
    ----------
    windows : sequence of Window
        At least one; all of equal length, with all channels.
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
    fits : mapping of str to ndarray, shape (n_window,)
        Outputs that state how well the model explains a window.
    conditions : mapping of str to ndarray, shape (n_window,)
        As from `conditions_of`.
    clearances : ndarray, shape (n_window,)
        Share of the flow through clearances that moves the first number in warmer oil.
    """

    numbers: Array
    obstacles: list[str | None]
    doubts: list[tuple[Issue, ...]]
    fits: Mapping[str, Array]
    conditions: Mapping[str, Array]
    clearances: Array


def measured_numbers(
    records: RecordBatch, feature: Feature, fits: Mapping[str, float] | None = None
) -> Measured:
    """Measure the numbers of valid windows; `fits` as of `doubts_of`."""
    measures, indicators = measure(records, feature.indicators), feature.indicators
    doubts = [doubts_of(each, measures.values, f"{label}.", fits) for label, each in indicators.items()]
    obstacles = zip(*(measures.obstacles[label] for label in indicators), strict=True)
    numbers = feature.values(measures.values)
    flow, share = feature.described.clearances
    through_all = measures.values.get(f"{next(iter(indicators))}.{flow}")
    clearances = numbers[:, 0] if through_all is None else share * through_all
    return Measured(
        numbers,
        [next(filter(None, reasons), None) for reasons in obstacles],
        [tuple(chain.from_iterable(each)) for each in zip(*doubts, strict=True)],
        {name: measures.values[name] for name, output in feature.outputs.items() if output.is_fit},
        conditions_of(feature, measures.values, records),
        clearances,
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


def channel_facts(samples: Array) -> dict[str, Array]:
    """Statistics of a channel in each window, independent of the other windows.

    Parameters
    ----------
    samples : ndarray, shape (n_window, n_time)

    Returns
    -------
    dict of str to ndarray, shape (n_window,)
        ``low`` and ``high``: 1 % and 99 % quantile, as order statistics. ``activity``: RMS difference between
        adjacent samples. ``at_end``: fraction of samples at the lowest or at the highest value, whichever is
        larger; ``is_at_high``: whether that is the highest. ``lowest`` and ``highest``.
    """
    n_time = samples.shape[1]
    rank = int(_TAIL * (n_time - 1))
    ordered = np.partition(samples, (rank, n_time - 1 - rank), axis=1)
    lowest, highest = samples.min(axis=1), samples.max(axis=1)
    at_low, at_high = (
        np.count_nonzero(samples == end[:, None], axis=1) / n_time for end in (lowest, highest)
    )
    with np.errstate(over="ignore", invalid="ignore"):
        activity = (
            np.sqrt(np.mean(np.diff(samples, axis=1) ** 2, axis=1)) if n_time > 1 else np.zeros(len(samples))
        )
    return {
        "low": ordered[:, rank],
        "high": ordered[:, n_time - 1 - rank],
        "activity": activity,
        "at_end": np.maximum(at_low, at_high),
        "lowest": lowest,
        "highest": highest,
        "is_at_high": at_high > at_low,
    }


def learned_range(channel: Channel, facts: Sequence[Mapping[str, Array]]) -> ChannelRange:
    """Range of a channel, learned from the statistics of all healthy windows."""
    low, high, activity, at_end = (
        np.concatenate([each[name] for each in facts]) for name in ("low", "high", "activity", "at_end")
    )
    span, wider = float(high.max() - low.min()), 1.0 + _FEW / low.size
    factor = _ACTIVITY**wider
    return ChannelRange(
        low=_widened(low, span, wider),
        high=_widened(high, span, wider),
        activity=(float(activity.min()) / factor, float(activity.max()) * factor),
        at_end=1.0 if channel in _COMMANDS else min(1.0, _PILE * float(at_end.max()) + _PILE_LEAST),
    )


def _widened(values: Array, span: float, wider: float) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    margin = wider * (_MARGIN * (high - low) + _OF_SPAN * span)
    return low - margin, high + margin


_FAR = 10.0
"""Healthy spreads in the distance from which a score on the side without an alarm is novel."""

_QUANTITIES = {
    "low": "1 % quantile",
    "high": "99 % quantile",
    "activity": "RMS difference between adjacent samples",
}


@dataclass(frozen=True)
class Verdict:
    """Verdict of a trained detector on one window.

    Attributes
    ----------
    score : float or None
        Output of the indicator, in its unit; None if it has none. Novel windows have a score too.
    alarm : bool or None
        Whether the window raises an alarm; None if it is not judged.
    margin : float or None
        Distance to the nearest limit in healthy spreads, negative beyond it; None if there is no score.
    fault : Issue or None
        Why the window is not judged.
    doubt : str
        Why the verdict is doubtful, which it remains all the same; empty if it is not.
    temperature : float or None
        Mean oil temperature [K]; None if it is not measured.
    """

    score: float | None
    alarm: bool | None
    margin: float | None
    fault: Issue | None = None
    doubt: str = ""
    temperature: float | None = None

    @property
    def is_beyond(self) -> bool | None:
        """Whether the score is beyond a limit, even if that is not an alarm; None if there is no score."""
        return None if self.margin is None else self.margin < 0.0


class Judge:
    """Judges windows with a trained detector. The verdict on a window does not depend on other windows."""

    def __init__(self, file: DetectorFile) -> None:
        self.file, self._feature = file, file.feature

    def judge(self, windows: Sequence[Window]) -> list[Verdict]:
        """A verdict on each window, in order."""
        verdicts = [Verdict(None, None, None, window.fault) for window in windows]
        sound = [place for place, window in enumerate(windows) if window.fault is None]
        if not sound:
            return verdicts
        records = records_of([windows[at] for at in sound], self.file.channels, self.file.sampling_frequency)
        found = measured_numbers(records, self._feature, self.file.fits)
        scores = self.file.scores(found.numbers).tolist()
        faults = findings(records, self.file.ranges)
        for row, place in enumerate(sound):
            own = {name: float(values[row]) for name, values in found.conditions.items()}
            verdict = verdict_of(
                self.file, scores[row], faults[row], found.obstacles[row], found.doubts[row], own
            )
            verdicts[place] = replace(verdict, temperature=own.get(TEMPERATURE))
        return verdicts


def verdict_of(
    file: DetectorFile,
    score: float,
    fault: Issue | None = None,
    obstacle: str | None = None,
    doubts: Sequence[Issue] = (),
    conditions: Mapping[str, float] = {},
) -> Verdict:
    """Verdict on a score.

    Parameters
    ----------
    fault : Issue, optional
        Why the window is not judged. For novel windows, score and margin are still given, and the fault
        states whether the score is beyond a limit.
    obstacle : str, optional
        Why there is no score.
    doubts : sequence of Issue
        About the numbers of the window. If a quantity can only be positive, and is not, or if the model
        explains nothing, a window without an alarm is novel; any window if it is the flow gain.
    conditions : mapping of str to float
        Conditions of the window; it is novel if they are outside of those that healthy windows cover. A leak
        may move an estimate: then an alarm stays and is doubtful.
    """
    other = outside(file.conditions, file.basis.n_window, conditions)
    if other is not None and other.where == TEMPERATURE:
        fault = fault or other
    if fault is not None and fault.kind != "novel":
        return Verdict(None, None, None, fault)
    if math.isnan(score):
        reason = Issue(obstacle or "the indicator has no value", kind="no_number")
        return Verdict(None, None, None, fault or reason)
    limits = [(score - file.limits.low)] if file.limits.low is not None else []
    limits += [file.limits.high - score] if file.limits.high is not None else []
    distance = min(limits, default=math.inf)
    margin = distance / file.healthy.spread
    signs = {("not_positive", name) for name in file.positive} | {("unexplained", name) for name in file.fits}
    other_machine = (each for each in doubts if (each.kind, each.where) in signs)
    # No leak reverses the valve: 60 L/min of any law leave 0.4 of its gain; a wrong sign makes it negative.
    reasons = [each for each in other_machine if distance >= 0.0 or each.where.endswith(".flow_gain")]
    fault = fault or next((Issue(each.message, kind="novel") for each in reasons), None)
    if distance >= 0.0:
        fault = fault or other or _wrong_side(file, score)
    elif other is not None:
        doubts = [*doubts, other]
    if fault is None:
        more = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
        return Verdict(
            score, distance < 0.0, margin, doubt="".join(each.message for each in doubts[:1]) + more
        )
    if distance < 0.0:
        fault = replace(fault, message=f"{fault.message}; the score is also beyond its limit")
    return Verdict(score, None, margin, fault)


def _wrong_side(file: DetectorFile, score: float) -> Issue | None:
    """Why a score is novel: a leak moves it to one side, and it is far out on the other.

    Far is twice as far from the healthy median as all healthy scores, and ten healthy spreads more.
    """
    limits, healthy = file.limits, file.healthy
    if healthy.range is None or (limits.low is None) == (limits.high is None):
        return None
    lowest, highest = healthy.range
    width, distance, side = highest - healthy.centre, score - healthy.centre, "above"
    if limits.low is None:
        width, distance, side = healthy.centre - lowest, -distance, "below"
    if distance <= 2.0 * width + _FAR * healthy.spread:
        return None
    return Issue(
        f"the score, {file.score_text(score)}, is far {side} all healthy scores"
        f" ({file.score_text(lowest)} to {file.score_text(highest)}):"
        " are two channels swapped, or is a sign wrong?",
        kind="novel",
    )


def findings(records: RecordBatch, ranges: Mapping[Channel, ChannelRange]) -> list[Issue | None]:
    """Fault of each window: stuck, clipped, novel, or None."""
    facts = {channel: channel_facts(records[channel]) for channel in ranges if channel in records.channels}
    found = []
    for row in range(records.n_record):
        values = {channel: {name: each[row] for name, each in own.items()} for channel, own in facts.items()}
        found.append(_finding(values, ranges))
    return found


def _finding(
    facts: Mapping[Channel, Mapping[str, float]], ranges: Mapping[Channel, ChannelRange]
) -> Issue | None:
    kinds: dict[str, list[str]] = {"stuck": [], "clipped": [], "novel": []}
    for channel, own in facts.items():
        healthy = ranges[channel]
        if own["lowest"] == own["highest"] and healthy.at_end < 1.0:
            kinds["stuck"].append(f"{channel} is constant, but varies in healthy windows")
        if comparable(own["at_end"]) > comparable(healthy.at_end):
            end = "highest" if own["is_at_high"] else "lowest"
            shown = shown_quantity(float(own[end]), channel.unit)
            kinds["clipped"].append(
                f"{own['at_end']:.1%} of {channel} are at its {end} value, {shown};"
                f" healthy windows allow {healthy.at_end:.1%}"
            )
        for name, quantity in _QUANTITIES.items():
            low, high = getattr(healthy, name)
            if not low <= own[name] <= high:
                now, least, most = (
                    shown_quantity(float(each), channel.unit) for each in (own[name], low, high)
                )
                kinds["novel"].append(
                    f"the {quantity} of {channel} is {now}; healthy windows allow {least} to {most}"
                )
    for kind, texts in kinds.items():
        if texts:
            return Issue(texts[0] + (f" (and {len(texts) - 1} more)" if len(texts) > 1 else ""), kind=kind)
    return None
