"""Since when the leakage grows, how fast, and when it reaches a limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from itertools import pairwise
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.arguments import positive_of, refusal
from hydrofdi.api.histories import FIRST_DATE, History, history_of
from hydrofdi.api.records.sources import Said
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.evaluation.change_point import FEWEST, ChangePointModel, inliers
from hydrofdi.evaluation.courses import LAWS, Draws, Estimate
from hydrofdi.records import Array
from hydrofdi.records.dates import instant
from hydrofdi.report.table import Column, Table, finite, quantity
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import number_text, percent, plain, readable_unit, time_text, typeset
from hydrofdi.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DAY = 86400.0
_MOST_POINTS = 400
"""Most points; more are joined."""
_FEW = 0.1
"""Share of the usual number of scores below which a point is left out."""
_KNOWN, _VARIES = 0.75, 1.0
"""Least share of points with an oil temperature, and least standard deviation of it [K], to compensate it."""
_LEAST_RATE = 0.002


@dataclass(frozen=True, eq=False)
class Points:
    """Medians of the scores of equal spans of time.

    Attributes
    ----------
    time, score, temperature : ndarray, shape (n,)
        [s], unit of the score, [K].
    n_score : ndarray, shape (n,)
    is_used : ndarray, shape (n,)
        False for outliers, and for points without oil temperature if that is compensated.
    """

    time: Array
    score: Array
    temperature: Array
    n_score: NDArray[np.int64]
    is_used: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, repr=False)
class Trend:
    """The trend of a score, as `hydrofdi.trend` returns it.

    Attributes
    ----------
    history : History
    points : Points
    every : float
        Span of a point [s].
    p_value : float
        Probability of as much evidence of a change in a history without one.
    draws : Draws
        Equally probable courses of the score, with a change if `has_trend`; time in days.
    limit : float or None
        In the unit of the score.
    """

    history: History
    points: Points
    every: float
    p_value: float
    draws: Draws
    limit: float | None
    false_alarm_rate: float
    confidence: float
    is_compensated: bool
    remarks: tuple[str, ...] = ()

    @property
    def has_trend(self) -> bool:
        """Whether a change of the level is shown at the false-alarm rate."""
        return self.p_value <= self.false_alarm_rate

    @property
    def duration(self) -> float:
        """From the first to the last point [s]; nothing is stated for longer than that after the last."""
        return float(self.draws.time[-1] - self.draws.time[0]) * _DAY

    def _of(self, draws: Array) -> Estimate:
        return Estimate.of(draws, self.confidence)

    @cached_property
    def onset(self) -> Estimate | None:
        """Beginning of the change [s]; None without a trend."""
        return self._instant(self.draws.onset) if self.has_trend else None

    @cached_property
    def level_before(self) -> Estimate:
        """Level before the change."""
        return self._of(self.draws.level)

    @cached_property
    def level_now(self) -> Estimate:
        """Level at the last point."""
        return self._of(self.draws.level + self.draws.growth)

    @cached_property
    def rate(self) -> Estimate | None:
        """Rate of change at the last point [unit/s]; None without a trend."""
        return self._of(self.draws.rate / _DAY) if self.has_trend else None

    @cached_property
    def reached(self) -> Estimate | None:
        """When the level reaches the limit [s].

        −∞: before the history. +∞: not within `duration` after its end. None without a trend or a limit.
        """
        if self.limit is None or not self.has_trend:
            return None
        return self._instant(self.draws.reached(self.limit))

    def _instant(self, days: Array) -> Estimate:
        found = Estimate.of(days, self.confidence, self.draws.spacing)
        return Estimate(*(_DAY * each for each in (found.value, found.low, found.high)))

    def probability(self, time: float) -> float:
        """Probability that the level reaches the limit up to an instant [s], at most the horizon."""
        assert self.limit is not None
        return float(np.mean(self.draws.reached(self.limit) <= time / _DAY))

    @property
    def horizon(self) -> float:
        """Latest instant of a statement [s]."""
        return float(self.draws.time[-1]) * _DAY + self.duration

    @property
    def laws(self) -> dict[str, float]:
        """Name of a law of growth → its probability."""
        shares = np.bincount(self.draws.law, minlength=len(LAWS)) / self.draws.law.size
        names = dict.fromkeys(law.name for law in LAWS)
        return {
            name: float(sum(share for share, law in zip(shares, LAWS, strict=True) if law.name == name))
            for name in names
        }

    @property
    def temperature_effect(self) -> Estimate | None:
        """Change of the score with the oil temperature [unit/K]; None if it is not compensated."""
        return self._of(self.draws.slopes[:, 0]) if self.is_compensated else None

    @cached_property
    def _unit(self) -> str:
        sizes = [float(np.abs(self.points.score).max()), self.limit or 0.0]
        return readable_unit(self.history.unit, max(sizes))

    @property
    def factor(self) -> float:
        """Shown over stored values of the score."""
        return 1.0 if self._unit == self.history.unit else convert(1.0, self._unit)

    @property
    def shown_unit(self) -> str:
        """Unit for display; empty if there is none."""
        return "" if self._unit == "1" else typeset(self._unit)

    def amount(self, value: float) -> str:
        """A score for display."""
        return f"{number_text(float(value), 3, self.factor)} {self.shown_unit}".rstrip()

    def when(self, time: float) -> str:
        """An instant for display."""
        if math.isinf(time):
            return "before the history" if time < 0 else f"not within {time_or_days(self.duration)}"
        if not self.history.is_dated:
            return f"day {plain(time / _DAY, 4)}" if self.every >= _DAY / 2 else time_text(time)
        text = f"{datetime.fromtimestamp(time, UTC):%Y-%m-%d %H:%M}"
        return text[:10] if self.every >= _DAY / 2 else text

    def _range(self, found: Estimate, text: Callable[[float], str]) -> str:
        """A value and its interval; a unit that all have stands once."""
        value, low, high = (text(each) for each in (found.value, found.low, found.high))
        unit = f" {self.shown_unit}" if text == self.amount and self.shown_unit else ""
        return f"{value} ({low.removesuffix(unit)} to {high})"

    @property
    def answer(self) -> str:
        """Whether there is a trend, since when, and when the limit is reached, in one or two sentences."""
        span = time_or_days(self.duration)
        if self.onset is None:
            level = self._range(self.level_now, self.amount)
            return f"No trend in {span} (p = {self.p_value:.2g}): the {self.history.meaning} is {level}."
        word = "grows" if self.level_now.value >= self.level_before.value else "falls"
        first = f"The {self.history.meaning} {word} since {self._range(self.onset, self.when)}."
        if self.limit is None or self.reached is None:
            return first
        limit, at = self.amount(self.limit), self.reached
        end = self.horizon - self.duration
        if at.high == -math.inf:
            return f"{first} It was beyond {limit} before."
        if at.value > self.horizon:
            chance = self.probability(self.horizon)
            early = f", with {percent(chance)} within that time" if at.low <= self.horizon else ""
            return f"{first} It most probably does not reach {limit} within {span}{early}."
        on = "on" if self.history.is_dated else "at"
        verb = "reached" if at.value <= end else "reaches"
        return f"{first} It {verb} {limit} {on} {self._range(at, self.when)}."

    def facts(self) -> dict[str, str]:
        """What stands beside the answer, for display."""
        points, used = self.points, int(self.points.is_used.sum())
        left = f", {len(points.time) - used} left out" if used < len(points.time) else ""
        ends = f"{self.when(self.draws.time[0] * _DAY)} to {self.when(self.draws.time[-1] * _DAY)}"
        found = {
            "history": f"{ends}, {used} points of {time_or_days(self.every)}{left}",
            "evidence": f"p = {self.p_value:.2g}, a trend if at most {percent(self.false_alarm_rate)}",
            "intervals": f"{100.0 * self.confidence:g} %",
        }
        if self.rate is not None:
            span = 30.0 * self.every
            laws = ", ".join(f"{name} {percent(share)}" for name, share in self.laws.items())
            found |= {
                "law": laws,
                "level before": self._range(self.level_before, self.amount),
                "level now": self._range(self.level_now, self.amount),
                "rate now": self._range(
                    Estimate(*(span * each for each in (self.rate.value, self.rate.low, self.rate.high))),
                    self.amount,
                )
                + f" in {time_or_days(span)}",
            }
        if (effect := self.temperature_effect) is not None:
            found["oil temperature"] = f"compensated, {self._range(effect, self.amount)} per K"
        return found

    @property
    def table(self) -> Table:
        """A row for each point: time [s], score, oil temperature [K], and the level with its interval."""
        points = self.points
        tail = (1.0 - self.confidence) / 2.0
        low, level, high = np.quantile(self.draws.levels(points.time / _DAY), (tail, 0.5, 1.0 - tail), axis=1)
        unit, sizes = self.history.unit, [float(np.abs(points.score).max())]
        return Table(
            (
                Column("time", points.time, "s", title="time", text=self.when),
                quantity("score", points.score, unit, self.history.meaning, sizes=sizes),
                *(
                    quantity(name, values, unit, sizes=sizes)
                    for name, values in (("level", level), ("level_low", low), ("level_high", high))
                ),
                Column("oil_temperature", points.temperature, "K"),
                Column("n_score", points.n_score, title="scores"),
                Column("is_used", points.is_used, text=lambda each: "" if each else "left out", is_text=True),
            ),
            title=f"{self.history.meaning} of {self.history.name}",
            row="point",
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as ``hydrofdi trend --json`` prints it."""
        history, reached = self.history, self.reached
        return {
            "source": history.name,
            "meaning": history.meaning,
            "unit": history.unit,
            "clock": "unix" if history.is_dated else "stream",
            "begin": self._stated(self.draws.time[0] * _DAY),
            "end": self._stated(self.draws.time[-1] * _DAY),
            "horizon": self._stated(self.horizon),
            "every_s": self.every,
            "has_trend": self.has_trend,
            "p_value": self.p_value,
            "false_alarm_rate": self.false_alarm_rate,
            "confidence": self.confidence,
            "onset": self._instants(self.onset),
            "laws": self.laws if self.has_trend else None,
            "level_before": _numbers(self.level_before),
            "level_now": _numbers(self.level_now),
            "rate_per_s": _numbers(self.rate),
            "temperature_effect_per_K": _numbers(self.temperature_effect),
            "limit": self.limit,
            "limit_reached": self._instants(reached),
            "probability_of_limit": None
            if reached is None
            else {
                "until_end": self.probability(self.horizon - self.duration),
                "until_horizon": self.probability(self.horizon),
            },
            "points": [*self.table],
            "remarks": [*self.remarks],
            "answer": self.answer,
        }

    def _stated(self, time: float) -> dict[str, Any]:
        date = None
        if self.history.is_dated and math.isfinite(time):
            date = f"{datetime.fromtimestamp(time, UTC):%Y-%m-%dT%H:%M:%SZ}"
        return {"time_s": finite(float(time)), "date": date}

    def _instants(self, found: Estimate | None) -> dict[str, Any] | None:
        if found is None:
            return None
        return {name: self._stated(getattr(found, name)) for name in ("value", "low", "high")}

    def plot(self) -> Figure:
        """The points, the level with its interval, the onset, the limit and when it is reached."""
        from hydrofdi.report.figures.trend import draw_trend

        used, draws = self.points.is_used, self.draws
        unit = "" if self.history.is_dated else "days" if self.every >= _DAY / 2 else "min"
        span = 60.0 if unit == "min" else _DAY
        values = self.points.score.copy()
        if self.is_compensated:
            known = np.isfinite(self.points.temperature)
            mean = self.points.temperature[used].mean()
            values[known] -= np.median(draws.slopes[:, 0]) * (self.points.temperature[known] - mean)
        end = self.horizon if self.has_trend and self.limit is not None else self.horizon - self.duration
        instants, tail = np.linspace(self.points.time[0], end, 300), (1.0 - self.confidence) / 2.0
        levels = np.quantile(draws.levels(instants / _DAY), (tail, 0.5, 1.0 - tail), axis=1)
        onset, reached = (
            None if found is None else (found.value / span, found.low / span, found.high / span)
            for found in (self.onset, self.reached)
        )
        return draw_trend(
            self.answer.partition(". ")[0].rstrip("."),
            f"{self.history.meaning} [{self.shown_unit or '-'}]",
            (self.points.time / span, self.factor * values, used),
            (instants / span, self.factor * levels),
            onset,
            None if self.limit is None else self.factor * self.limit,
            reached,
            time_unit=unit,
        )

    def __repr__(self) -> str:
        return self.answer


def time_or_days(seconds: float) -> str:
    """A duration for display."""
    days = seconds / _DAY
    return counted(round(days), "day") if days >= 0.995 else time_text(seconds)


def _numbers(found: Estimate | None) -> dict[str, float | None] | None:
    return (
        None if found is None else {name: finite(getattr(found, name)) for name in ("value", "low", "high")}
    )


def trend(
    data: Any,
    *,
    limit: str | float | None = None,
    indicator: str = "",
    output: str = "",
    every: str | float = "1 day",
    begin: str | None = None,
    false_alarm_rate: str | float = "1 %",
    confidence: float | str = 0.95,
    sampling_frequency: str | float | None = None,
) -> Trend:
    """State since when a score grows, how fast, and when it reaches a limit, as ``hydrofdi trend`` does.

    Parameters
    ----------
    data : path, list of paths, or list of mappings
        Logs of a monitor (``hydrofdi monitor --log``) or its lines; or measured records with dates, in files.
    limit : str or float, optional
        Score whose date is wanted, such as ``0.5 L/min``.
    indicator : str, optional
        What is measured of records; by default the balance that their sensors allow.
    output : str, optional
        Output of the indicator; by default its first score.
    every : str or float
        Span of time whose scores make a point, their median.
    begin : str, optional
        Date at which the clock of a log is zero, such as ``2026-01-31T12:00Z``, if it does not state dates.
    false_alarm_rate : str or float
        Share of histories without a change in which a trend may be stated, from 0.2 %.
    confidence : str or float
        Confidence level of all intervals.
    sampling_frequency : str or float, optional
        Of a data file without a column of time [Hz].

    Returns
    -------
    Trend
        ``answer``, ``has_trend``, ``onset``, ``rate``, ``reached`` and more, with intervals; ``table``,
        ``plot()``.

    Raises
    ------
    ConfigError, DataError
        An argument is invalid, a record has no date, or the history has fewer than 12 points.
    """
    span = positive_of("every", every, "s", "a duration such as '1 day'")
    rate, level = (
        positive_of(name, given, "1", "a share such as '1 %'")
        for name, given in (("false_alarm_rate", false_alarm_rate), ("confidence", confidence))
    )
    if not _LEAST_RATE <= rate < 1.0:
        raise ConfigError(f"false_alarm_rate: must be from 0.2 % to below 100 %; found {false_alarm_rate!r}")
    if not 0.0 < level < 1.0:
        raise ConfigError(f"confidence: must be below 1; found {confidence!r}")
    history = history_of(data, indicator, output, Said(sampling_frequency))
    history = history if begin is None else _begun(history, begin)
    wanted = None if limit is None else _limit_of(limit, history.unit)
    points, span, remarks = points_of(history, span)
    known = np.isfinite(points.temperature)
    is_compensated = bool(
        known.mean() >= _KNOWN and np.std(points.temperature[known]) >= _VARIES and known.sum() >= FEWEST
    )
    used = known if is_compensated else np.ones(known.size, dtype=bool)
    if used.sum() < FEWEST:
        raise DataError(
            f"{history.name}: has {counted(int(used.sum()), 'point')} of {time_or_days(span)}; a trend needs"
            f" {FEWEST} or more: state a shorter span with 'every', or wait"
        )
    days, warm = points.time / _DAY, points.temperature if is_compensated else None
    is_used = used.copy()
    is_used[used] = inliers(points.score[used])
    points = Points(points.time, points.score, points.temperature, points.n_score, is_used)
    model = ChangePointModel(days[is_used], None if warm is None else warm[is_used])
    p_value = model.p_value(points.score[is_used])
    draws = model.draws(points.score[is_used], is_changed=p_value <= rate)
    if not is_compensated:
        remarks.append("the oil temperature is not compensated: its seasons may look like a trend")
    notes = (*history.remarks, *remarks)
    return Trend(history, points, span, p_value, draws, wanted, rate, level, is_compensated, notes)


def _begun(history: History, begin: str) -> History:
    """The history on a clock that counts from 1970."""
    if history.is_dated:
        raise ConfigError(f"begin: the clock of {history.name} states dates already")
    try:
        zero = instant(begin).nanoseconds / 1e9
    except (ValueError, AttributeError) as error:
        raise ConfigError(f"begin: {error}") from None
    if zero < FIRST_DATE:
        raise ConfigError(f"begin: must be after 2001-09-09; found {begin!r}")
    return replace(history, time=zero + history.time)


def _limit_of(limit: Any, unit: str) -> float:
    if isinstance(limit, bool) or not isinstance(limit, str | Real):
        raise refusal("limit", f"a score in {unit}, such as a number with its unit", limit)
    try:
        value = parse_quantity(limit, unit) if isinstance(limit, str) else float(limit)
    except ValueError as error:
        raise ConfigError(f"limit: {error}") from None
    if not math.isfinite(value):
        raise ConfigError(f"limit: must be finite; found {limit!r}")
    return value


def points_of(history: History, span: float) -> tuple[Points, float, list[str]]:
    """Points of a history, their span [s], which may be longer than asked for, and remarks."""
    remarks = list[str]()
    n_most = np.unique(np.floor(history.time / span)).size
    if n_most > _MOST_POINTS:
        span *= math.ceil(n_most / _MOST_POINTS)
        remarks.append(f"points of {time_or_days(span)}, because there would be more than {_MOST_POINTS}")
    starts = np.flatnonzero(np.diff(np.floor(history.time / span), prepend=-np.inf))
    parts = [slice(*ends) for ends in pairwise([*starts.tolist(), history.time.size])]
    counts = np.array([part.stop - part.start for part in parts])
    parts = [part for part, n in zip(parts, counts, strict=True) if n >= _FEW * np.median(counts)]
    if len(parts) < counts.size:
        remarks.append(f"left out: {counted(counts.size - len(parts), 'point')} of few scores")
    warm = [history.temperature[part] for part in parts]
    points = Points(
        np.array([np.median(history.time[part]) for part in parts]),
        np.array([np.median(history.score[part]) for part in parts]),
        np.array([np.mean(each[np.isfinite(each)]) if np.isfinite(each).any() else np.nan for each in warm]),
        np.array([part.stop - part.start for part in parts]),
        np.ones(len(parts), dtype=bool),
    )
    return points, span, remarks
