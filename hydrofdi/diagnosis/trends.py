"""Trend of a score: the evidence of a change in its history, estimates with intervals, and the answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import cached_property
from typing import Any, NoReturn

import numpy as np

from hydrofdi.diagnosis.histories import DAY, History, SpanMedians, instant_text, points_of, time_or_days
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.evaluation.change_point import FEWEST, LAWS, ChangePointModel, Draws, inliers
from hydrofdi.evaluation.scores import Estimate
from hydrofdi.records import Array
from hydrofdi.settings.messages import convert, counted, number_text, percent, plain, readable_unit, typeset
from hydrofdi.tables.answer import Answer, Piece, Strong
from hydrofdi.tables.table import Column, Table, quantity
from hydrofdi.tables.table import plain as for_json

_KNOWN, _VARIES = 0.75, 1.0
"""Least share of points with an oil temperature, and least standard deviation of it [K], to compensate it."""


@dataclass(frozen=True, eq=False, repr=False)
class TrendAnswer(Answer):
    """The trend of a score: estimates, and what they say in sentences, a table and plain data.

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
    points: SpanMedians
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
        return float(self.draws.time[-1] - self.draws.time[0]) * DAY

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
        return self._of(self.draws.rate / DAY) if self.has_trend else None

    @cached_property
    def reached(self) -> Estimate | None:
        """When the level reaches the limit [s].

        −∞: before the history. +∞: not within `duration` after its end. None without a trend or a limit.
        """
        if self.limit is None or not self.has_trend:
            return None
        return self._instant(self.draws.reached(self.limit))

    def _instant(self, days: Array) -> Estimate:
        own = Estimate.of(days, self.confidence, self.draws.spacing)
        return Estimate(*(DAY * day for day in (own.value, own.low, own.high)))

    def probability(self, time: float) -> float:
        """Probability that the level reaches the limit up to an instant [s], at most the horizon."""
        assert self.limit is not None
        return float(np.mean(self.draws.reached(self.limit) <= time / DAY))

    @property
    def horizon(self) -> float:
        """Latest instant of a statement [s]."""
        return float(self.draws.time[-1]) * DAY + self.duration

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
        return convert(1.0, self._unit, self.history.unit)

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
        if self.every < DAY / 2:
            return instant_text(time)
        return instant_text(time)[:10] if self.history.is_dated else f"day {plain(time / DAY, 4)}"

    def _range(self, interval: Estimate, text: Callable[[float], str]) -> str:
        """A value and its interval; a unit that all have stands once."""
        value, low, high = (text(each) for each in (interval.value, interval.low, interval.high))
        unit = f" {self.shown_unit}" if text == self.amount and self.shown_unit else ""
        return f"{value} ({low.removesuffix(unit)} to {high})"

    @property
    def answer(self) -> str:
        """Whether there is a trend, since when, and when the limit is reached, in one or two sentences."""
        span = time_or_days(self.duration)
        if self.onset is None:
            level = self._range(self.level_now, self.amount)
            return f"No trend in {span} (p = {self.p_value:.2g}): the {self.history.meaning} is {level}."
        word = "growing" if self.level_now.value >= self.level_before.value else "falling"
        first = f"The {self.history.meaning} has been {word} since {self._range(self.onset, self.when)}."
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

    def parts(self) -> Iterator[Piece]:
        """The history, its evidence, and the answer."""
        yield from (Strong(self.history.name), self._facts(), Strong(self.answer))

    def asides(self) -> Iterator[str]:
        """The remarks."""
        return (f"note: {remark}" for remark in self.remarks)

    def _facts(self) -> dict[str, str]:
        """What stands beside the answer."""
        points, used = self.points, int(self.points.is_used.sum())
        left = f", {len(points.time) - used} left out" if used < len(points.time) else ""
        ends = f"{self.when(self.draws.time[0] * DAY)} to {self.when(self.draws.time[-1] * DAY)}"
        facts = {
            "history": f"{ends}, {used} points of {time_or_days(self.every)}{left}",
            "evidence": f"p = {self.p_value:.2g}, a trend if at most {percent(self.false_alarm_rate)}",
            "intervals": f"{100.0 * self.confidence:g} %",
        }
        if self.rate is not None:
            span = 30.0 * self.every
            laws = ", ".join(f"{name} {percent(share)}" for name, share in self.laws.items())
            facts |= {
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
            facts["oil temperature"] = f"compensated, {self._range(effect, self.amount)} per K"
        return facts

    def _levels(self, time: Array) -> Array:
        """Lower end, median and upper end of the level at instants [s], shape (3, n)."""
        tail = (1.0 - self.confidence) / 2.0
        return np.asarray(np.quantile(self.draws.levels(time / DAY), (tail, 0.5, 1.0 - tail), axis=1))

    @property
    def table(self) -> Table:
        """A row for each point: time [s], score, oil temperature [K], and the level with its interval."""
        points = self.points
        low, level, high = self._levels(points.time)
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
        record: dict[str, Any] = for_json({
            "source": history.name,
            "meaning": history.meaning,
            "unit": history.unit,
            "clock": "unix" if history.is_dated else "stream",
            "begin": self._stated(self.draws.time[0] * DAY),
            "end": self._stated(self.draws.time[-1] * DAY),
            "horizon": self._stated(self.horizon),
            "every_s": self.every,
            "has_trend": self.has_trend,
            "p_value": self.p_value,
            "false_alarm_rate": self.false_alarm_rate,
            "confidence": self.confidence,
            "onset": self._instants(self.onset),
            "laws": self.laws if self.has_trend else None,
            "level_before": self.level_before,
            "level_now": self.level_now,
            "rate_per_s": self.rate,
            "temperature_effect_per_K": self.temperature_effect,
            "limit": self.limit,
            "limit_reached": self._instants(reached),
            "probability_of_limit": None
            if reached is None
            else {
                "until_end": self.probability(self.horizon - self.duration),
                "until_horizon": self.probability(self.horizon),
            },
            "points": self.table,
            "remarks": self.remarks,
            "answer": self.answer,
        })  # fmt: skip
        return record

    def _stated(self, time: float) -> dict[str, Any]:
        date = None
        if self.history.is_dated and math.isfinite(time):
            date = f"{datetime.fromtimestamp(time, UTC):%Y-%m-%dT%H:%M:%SZ}"
        return {"time_s": float(time), "date": date}

    def _instants(self, interval: Estimate | None) -> dict[str, Any] | None:
        if interval is None:
            return None
        return {name: self._stated(getattr(interval, name)) for name in ("value", "low", "high")}

    def drawing(self) -> dict[str, Any]:
        """What a figure shows: points, levels, onset, limit and when it is reached, in units for display."""
        used, draws = self.points.is_used, self.draws
        unit = "" if self.history.is_dated else "days" if self.every >= DAY / 2 else "min"
        span = 60.0 if unit == "min" else DAY
        values = self.points.score.copy()
        if self.is_compensated:
            known = np.isfinite(self.points.temperature)
            mean = self.points.temperature[used].mean()
            values[known] -= np.median(draws.slopes[:, 0]) * (self.points.temperature[known] - mean)
        end = self.horizon if self.has_trend and self.limit is not None else self.horizon - self.duration
        instants = np.linspace(self.points.time[0], end, 300)
        onset, reached = (
            None if interval is None else (interval.value / span, interval.low / span, interval.high / span)
            for interval in (self.onset, self.reached)
        )
        return {
            "title": self.answer.partition(". ")[0].rstrip("."),
            "label": f"{self.history.meaning} [{self.shown_unit or '-'}]",
            "points": (self.points.time / span, self.factor * values, used),
            "levels": (instants / span, self.factor * self._levels(instants)),
            "onset": onset,
            "limit": None if self.limit is None else self.factor * self.limit,
            "reached": reached,
            "time_unit": unit,
        }


class Trends(Answer, dict[str, TrendAnswer]):
    """Machine of a fleet → its trend; `without` has those that have none, with the reason."""

    def __init__(self, trends: Mapping[str, TrendAnswer], without: Mapping[str, DataError]) -> None:
        super().__init__(trends)
        self.without = {machine: str(error) for machine, error in without.items()}

    def parts(self) -> Iterator[Piece]:
        """The answer of each machine."""
        for machine, each in self.items():
            yield (Strong if each.has_trend else str)(f"{machine}: {each.answer}")

    def asides(self) -> Iterator[str]:
        """False trends that are expected, remarks, and machines without a trend."""
        n_false = len(self) * next(iter(self.values())).false_alarm_rate
        yield f"note: of as many machines without a change, {n_false:.2g} would have a trend"
        yield from dict.fromkeys(f"note: {text}" for each in self.values() for text in each.remarks)
        yield from (f"note: {reason}" for reason in self.without.values())

    def to_dict(self) -> dict[str, Any]:
        """Everything as ``hydrofdi trend --json`` prints it."""
        return {"machines": {name: each.to_dict() for name, each in self.items()}, "without": self.without}

    def plot(self) -> NoReturn:
        """A figure is of one machine."""
        raise ConfigError(f"figure: is of one machine; choose it with 'machine': {', '.join(self)}")


def estimate(
    history: History, span: float, limit: float | None, false_alarm_rate: float, confidence: float
) -> TrendAnswer:
    """Estimates of the trend of a history, in points of a span [s].

    Raises
    ------
    DataError
        The history has too few points.
    """
    points, span, remarks = points_of(history, span)
    known = np.isfinite(points.temperature)
    is_compensated = bool(
        known.mean() >= _KNOWN and np.std(points.temperature[known]) >= _VARIES and known.sum() >= FEWEST
    )
    used = known if is_compensated else np.ones(known.size, dtype=bool)
    if used.sum() < FEWEST:
        few = (
            f"{history.name}: has {counted(int(used.sum()), 'point')} of {time_or_days(span)}; a trend needs"
            f" {FEWEST} or more: state a shorter span with 'every', or wait"
        )
        raise DataError("; ".join([few, *history.remarks]))
    is_used = used.copy()
    is_used[used] = inliers(points.score[used])
    points, used = replace(points, is_used=is_used), is_used
    scores, warm = points.score[used], points.temperature[used] if is_compensated else None
    model = ChangePointModel(points.time[used] / DAY, warm)
    p_value = model.p_value(scores)
    draws = model.draws(scores, is_changed=p_value <= false_alarm_rate)
    if not is_compensated:
        remarks.append("the oil temperature is not compensated: its seasons may look like a trend")
    notes = (*history.remarks, *remarks)
    return TrendAnswer(
        history, points, span, p_value, draws, limit, false_alarm_rate, confidence, is_compensated, notes
    )
