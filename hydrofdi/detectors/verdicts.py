"""What is measured of windows, their healthy ranges and conditions, and verdicts by them and by limits."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.detectors.configuration import Feature
from hydrofdi.detectors.file import ChannelRange, DetectorFile, Scale
from hydrofdi.detectors.rules import OF_ONE
from hydrofdi.errors import Issue
from hydrofdi.evaluation.scores import Direction, comparable
from hydrofdi.indicators import measure
from hydrofdi.indicators.faults import OF_LEAKS, doubts_of
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.defects import update_rate
from hydrofdi.records.streams import Window
from hydrofdi.settings.messages import convert, number_text, shown_quantity
from hydrofdi.units import ZEROS

Ranges = Mapping[str, tuple[float, float]]
"""Condition → lowest and highest value, in SI."""

_NARROW, _NARROW_SHARE = 10.0, 0.1
"""Span below which a range is narrow: of the temperature [K], of an estimate relative to its size."""

_OF_RANGE = 0.1
"""Margin of a covered range, as a share of its width and of a narrow width together; a choice."""

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

_MORE_HELD = 0.25
"""Fraction of repeated samples, beyond that of healthy windows, of a channel that is updated more slowly."""

_SLOWER = 0.7
"""Ratio to the slowest updates of healthy windows below which a channel is updated more slowly."""

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
        larger; ``is_at_high``: whether that is the highest. ``lowest`` and ``highest``. ``held``: fraction of
        samples that repeat the one before, without those at an end value. ``rate``: updates in a sampling
        period, 1 unless the channel is held or was interpolated.
    """
    n_time = samples.shape[1]
    rank = int(_TAIL * (n_time - 1))
    ordered = np.partition(samples, (rank, n_time - 1 - rank), axis=1)
    lowest, highest = samples.min(axis=1), samples.max(axis=1)
    at_low, at_high = (
        np.count_nonzero(samples == end[:, None], axis=1) / n_time for end in (lowest, highest)
    )
    repeats = (samples[:, 1:] == samples[:, :-1]) & (samples[:, 1:] != lowest[:, None])
    repeats &= samples[:, 1:] != highest[:, None]
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
        "held": np.count_nonzero(repeats, axis=1) / n_time,
        "rate": np.array([update_rate(row, np.arange(float(n_time))) or 1.0 for row in samples]),
    }


def learned_range(channel: Channel, facts: Sequence[Mapping[str, Array]]) -> ChannelRange:
    """Range of a channel, learned from the statistics of all healthy windows."""
    names = ("low", "high", "activity", "at_end", "held", "rate")
    columns = (np.concatenate([each[name] for each in facts]) for name in names)
    low, high, activity, at_end, repeated, rate = columns
    span, wider = float(high.max() - low.min()), 1.0 + _FEW / low.size
    factor = _ACTIVITY**wider
    return ChannelRange(
        low=_widened(low, span, wider),
        high=_widened(high, span, wider),
        activity=(float(activity.min()) / factor, float(activity.max()) * factor),
        at_end=1.0 if channel in _COMMANDS else min(1.0, _PILE * float(at_end.max()) + _PILE_LEAST),
        held=1.0 if channel in _COMMANDS else min(1.0, float(repeated.max()) + _MORE_HELD),
        rate=0.0 if channel in _COMMANDS else _SLOWER * float(rate.min()),
    )


def _widened(values: Array, span: float, wider: float) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    margin = wider * (_MARGIN * (high - low) + _OF_SPAN * span)
    return low - margin, high + margin


def outside(covered: Ranges, n_window: int, conditions: Mapping[str, float]) -> Issue | None:
    """The first condition of a window that is outside of the range of the healthy windows and its margin."""
    for name, (low, high) in covered.items():
        value = conditions.get(name, math.nan)
        margin = _OF_RANGE * (1.0 + _FEW / n_window) * (high - low + _narrow(name, low, high))
        if value < low - margin or value > high + margin:
            text = f"{_said(name)} is {_shown(name, value)}"
            return Issue(f"{text}; healthy windows cover {_range(name, low, high)}", name, kind="novel")
    return None


def coverage(covered: Ranges) -> str:
    """A sentence about the conditions that healthy windows cover, and which are not covered."""
    known = [f"{_said(name)} {_range(name, *ends)}" for name, ends in covered.items()]
    narrow = [
        _said(name)
        for name, (low, high) in covered.items()
        if not name.endswith("supply_pressure") and high - low < _narrow(name, low, high)
    ]
    missing = [] if TEMPERATURE in covered else ["the oil temperature is not recorded"]
    if narrow:
        missing.append(f"{' and '.join(narrow)} hardly {'vary' if len(narrow) > 1 else 'varies'}")
    text = f"It covers {', '.join(known)}" if known else "The conditions that it covers are not known"
    if not missing:
        return f"{text}."
    is_warm_and_cold = TEMPERATURE in covered and _said(TEMPERATURE) not in narrow
    advice = "" if is_warm_and_cold else ", so record warm and cold"
    return f"{text}; {', '.join(missing)}: other conditions are not covered{advice}."


def _narrow(name: str, low: float, high: float) -> float:
    return _NARROW if name == TEMPERATURE else _NARROW_SHARE * abs(low + high) / 2.0


def _said(name: str) -> str:
    return name.replace("_", " ") if name == TEMPERATURE else name


def _range(name: str, low: float, high: float) -> str:
    return f"{_shown(name, low)} to {_shown(name, high)}"


def _shown(name: str, value: float) -> str:
    return f"{value - ZEROS['°C']:.1f} °C" if name == TEMPERATURE else shown_quantity(value, "Pa")


_FAR = 10.0
"""Healthy spreads in the distance from which a score on the side without an alarm is novel."""

_MOST_WIDENED = 10.0
"""How much less certain than in healthy windows a score may be beyond their oil temperature; a choice."""

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
    leak : Leak or None
        Size of a leak, whatever is judged; None if the indicator does not state it.
    cause : str
        Of several numbers with limits of their own, the one that alarms, and what looks like it.
    """

    score: float | None = None
    alarm: bool | None = None
    margin: float | None = None
    fault: Issue | None = None
    doubt: str = ""
    temperature: float | None = None
    leak: Leak | None = None
    cause: str = ""

    @property
    def is_beyond(self) -> bool | None:
        """Whether the score is beyond a limit, even if that is not an alarm; None if there is no score."""
        return None if self.margin is None else self.margin < 0.0


def verdict_of(file: DetectorFile, score: float, measured: Measured, fault: Issue | None = None) -> Verdict:
    """Verdict on a score.

    Parameters
    ----------
    measured : Measured
        If a quantity can only be positive, and its doubts say that it is not, or if the model explains
        nothing, a window without an alarm is novel; any window if it is the flow gain. So is one with a
        condition that healthy windows do not cover; a leak may move it: then an alarm stays and is doubtful.
    fault : Issue, optional
        Why the window is not judged. For novel windows, score and margin are still given, and the fault
        states whether the score is beyond a limit.
    """
    known = measured.conditions
    other, temperature = outside(file.conditions, file.basis.n_window, known), known.get(TEMPERATURE)
    if other is not None and other.where == TEMPERATURE:
        is_compensated = 1.0 < file.widening(measured.numbers) <= _MOST_WIDENED
        fault, other = (fault, None) if is_compensated else (fault or other, other)
    if math.isnan(score) and (fault is None or fault.kind == "novel"):
        fault = fault or measured.fault or Issue("the indicator has no value", kind="no_number")
    if fault is not None and (fault.kind != "novel" or math.isnan(score)):
        return Verdict(fault=fault, temperature=temperature)
    limits = [(score - file.limits.low)] if file.limits.low is not None else []
    limits += [file.limits.high - score] if file.limits.high is not None else []
    distance = min(limits, default=math.inf)
    margin, doubts = distance / file.healthy.spread, measured.doubts
    signs = {("not_positive", name) for name in file.positive} | {("unexplained", name) for name in file.fits}
    other_machine = (each for each in doubts if (each.kind, each.where) in signs)
    # No leak reverses the valve: 60 L/min of any law leave 0.4 of its gain; a wrong sign makes it negative.
    reasons = [each for each in other_machine if distance >= 0.0 or each.where.endswith(".flow_gain")]
    fault = fault or next((Issue(each.message, kind="novel") for each in reasons), None)
    if distance >= 0.0:
        fault = fault or other or _wrong_side(file, score)
    else:
        # a leak may hide the compressibility, or seem to reverse it
        own = (each for each in doubts if not each.where.endswith(".bulk_modulus"))
        doubts = (*(each for each in own if each.kind not in OF_LEAKS), *filter(None, [other]))
    if fault is None:
        more = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
        cause = file.cause(measured.numbers) if distance < 0.0 else ""
        doubt = "".join(each.message for each in doubts[:1]) + more
        return Verdict(score, distance < 0.0, margin, None, doubt, temperature, measured.leak, cause)
    if distance < 0.0:
        fault = replace(fault, message=f"{fault.message}; the score is also beyond its limit")
    return Verdict(score, None, margin, fault, temperature=temperature, leak=measured.leak)


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
    frequency = records.sampling_frequency
    return [
        _finding({channel: of_row(own, row) for channel, own in facts.items()}, ranges, frequency)
        for row in range(records.n_record)
    ]


def _finding(
    facts: Mapping[Channel, Mapping[str, float]], ranges: Mapping[Channel, ChannelRange], frequency: float
) -> Issue | None:
    kinds: dict[str, list[str]] = {"stuck": [], "clipped": [], "novel": []}
    for channel, own in facts.items():
        healthy = ranges[channel]
        if own["lowest"] == own["highest"] and healthy.at_end < 1.0:
            kinds["stuck"].append(f"{channel} is constant, but varies in healthy windows")
        elif own["rate"] < healthy.rate:
            kinds["stuck"].append(
                f"{channel} is updated at {own['rate'] * frequency:.3g} Hz and held or interpolated between;"
                f" healthy windows allow {healthy.rate * frequency:.3g} Hz"
            )
        elif own["held"] > healthy.held:
            kinds["stuck"].append(
                f"{own['held']:.0%} of {channel} repeat the sample before; healthy windows allow"
                f" {healthy.held:.0%}: it is updated more slowly, or frozen for a part"
            )
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


def standardised(scores: ArrayLike, healthy: Scale, direction: Direction | None) -> Array:
    """Scores in healthy spreads from the healthy median; the sign changes if a leak lowers the score."""
    values = (np.asarray(scores, dtype=float) - healthy.centre) / healthy.spread
    return np.asarray(-values if direction is Direction.FALLING else values)


TEMPERATURE = Channel.OIL_TEMPERATURE

_ESTIMATES = ("bulk_modulus", "supply_pressure")


class Leak(NamedTuple):
    """Mean flow across piston and closed valve of any law, and its standard deviation [m³/s]."""

    flow: float
    deviation: float

    @property
    def interval(self) -> tuple[float, float]:
        """Two deviations around the flow, not below zero [m³/s]."""
        return max(0.0, self.flow - 2.0 * self.deviation), max(0.0, self.flow + 2.0 * self.deviation)

    def to_dict(self) -> dict[str, float]:
        """The flow, and the ends of its interval."""
        low, high = self.interval
        return {"flow": self.flow, "low": low, "high": high}

    @property
    def size(self) -> str:
        """The flow and its interval as text."""
        ends = (max(0.0, self.flow), *self.interval)
        flow, low, high = (number_text(convert(each, "L/min"), 2) for each in ends)
        return f"{flow} L/min ({low} to {high})"

    def __str__(self) -> str:
        return f"a mean leak of {self.size}"


@dataclass(frozen=True, slots=True)
class Measured:
    """What is measured of a window.

    Attributes
    ----------
    numbers : ndarray, shape (n_number,)
        NaN where there is none.
    fault : Issue or None
        Why numbers are missing.
    fits, conditions : mapping of str to float
        Outputs that state how well the model explains the samples; conditions of the machine, in SI, NaN if
        there are none.
    clearance : float
        Flow through all clearances, of which numbers take up shares.
    leak : Leak or None
        None if the indicator does not state it.
    """

    numbers: Array
    fault: Issue | None = None
    doubts: tuple[Issue, ...] = ()
    fits: Mapping[str, float] = field(default_factory=dict)
    conditions: Mapping[str, float] = field(default_factory=dict)
    clearance: float = math.nan
    leak: Leak | None = None


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


def measured_windows(
    records: RecordBatch, feature: Feature, fits: Mapping[str, float] | None = None
) -> list[Measured]:
    """What is measured of valid windows, bit-identical whatever the others are; `fits` as of `doubts_of`."""
    measures, indicators = measure(records, feature.indicators), feature.indicators
    values, outputs, numbers = measures.values, feature.outputs, feature.values(measures.values)
    doubts = [doubts_of(each, values, f"{label}.", fits) for label, each in indicators.items()]
    clearances = values.get(feature.through_all, numbers[:, 0])
    stated = {name: values[name] for name, output in outputs.items() if output.is_fit}
    judged = [*feature.numbers][: 1 if feature.score is None or feature.score.kind in OF_ONE else None]
    conditions = {name: values[name] for name in outputs if outputs[name].name in _ESTIMATES}
    conditions = {name: own for name, own in conditions.items() if own.ndim == 1 and name not in judged}
    if TEMPERATURE in records.channels:
        conditions = {TEMPERATURE: records[TEMPERATURE].mean(axis=1)} | conditions
    measured = []
    for row in range(records.n_record):
        obstacle = next(filter(None, (measures.obstacles[label][row] for label in indicators)), None)
        own_doubts = tuple(chain.from_iterable(each[row] for each in doubts))
        # A bulk modulus is unknown, not another one, where no compressibility is visible.
        unknown = {doubt.where: math.nan for doubt in own_doubts if doubt.kind == "incompressible"}
        leak = Leak(*(float(values[name][row]) for name in feature.leak)) if feature.leak else None
        measured.append(
            Measured(
                numbers[row],
                Issue(obstacle, kind="no_number") if obstacle else None,
                own_doubts,
                of_row(stated, row),
                of_row(conditions, row) | unknown,
                float(clearances[row]),
                leak if leak and math.isfinite(sum(leak)) else None,
            )
        )
    return measured


def of_row(columns: Mapping[str, Array], row: int) -> dict[str, float]:
    """One value of each column."""
    return {name: float(values[row]) for name, values in columns.items()}


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            scale = "is normalised" if channel in records.normalized else "is in counts"
            return f"{channel} {scale}, but a detector needs it in {channel.unit}"
    return None
