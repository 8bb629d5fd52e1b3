"""Limits of scores and charts from healthy records; of a machine with few of its own, also from a fleet.

Of a fleet by empirical Bayes: scores of a machine are normal with mean m and deviation s. Over the fleet m
and ln s are normal; their means and deviations are estimated from the fleet: Gelman et al., Bayesian Data
Analysis (2013), chapter 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.detectors.charts import FalseAlarms
from hydrofdi.detectors.configuration import TimedChart
from hydrofdi.detectors.file import ChartLimit, Fleet, Limits, Scale, TrainedScore
from hydrofdi.detectors.rules import make_chart
from hydrofdi.detectors.scores.contract import healthy_scale
from hydrofdi.detectors.training import N_PIECE, HealthyScores
from hydrofdi.detectors.verdicts import standardised
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import FEWEST_GROUPS, alarm_rate, left_out_outcomes
from hydrofdi.evaluation.scores import Direction, comparable
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.records import Array
from hydrofdi.settings.messages import time_text

_MOST_FOLDS = 25
"""Maximum number of cross-validation folds; with more groups, several are left out at a time."""

_REACH, _N_SPREAD, _N_GRID, _N_MEAN = 6.0, 200, 3, 128
"""Reach of the grid of ln s in deviations; numbers of its nodes, of grids, and of nodes of m."""

_LEAST_WEIGHT = 1e-12
"""Least weight of a node that is kept, relative to the largest."""


def fleet_of(scores: ArrayLike, groups: ArrayLike) -> Fleet | None:
    """Mean and spread over machines of the mean and of the log deviation of scores within a machine.

    Parameters
    ----------
    scores, groups : array_like, shape (n_score,)
        Healthy scores, and the machine of each. Machines with one score are left out.

    Returns
    -------
    Fleet or None
        None if fewer than five machines have two scores that differ.
    """
    from scipy.special import digamma, polygamma

    values, names = np.asarray(scores, dtype=float), np.asarray(groups)
    rows = [own for name in np.unique(names) if (own := values[names == name]).size > 1 and np.ptp(own) > 0.0]
    if len(rows) < FEWEST_GROUPS:
        return None
    means, variances = np.array([own.mean() for own in rows]), np.array([own.var(ddof=1) for own in rows])
    half = np.array([own.size - 1 for own in rows]) / 2.0
    # bias and variance of ln s of normal scores
    logs = np.log(variances) / 2.0 - (digamma(half) - np.log(half)) / 2.0
    sizes = np.array([own.size for own in rows])
    return Fleet(
        n_machine=len(rows),
        mean=float(means.mean()),
        mean_deviation=_between(means, variances / sizes),
        log_deviation=float(logs.mean()),
        log_deviation_deviation=_between(logs, polygamma(1, half) / 4.0),
    )


def _between(values: Array, sampling: Array) -> float:
    """Deviation over machines without sampling errors, widened as its own estimate is uncertain."""
    n, observed = values.size, float(values.var(ddof=1))
    # not less than the standard error of the observed variance: the difference may be negative
    between = max(observed - float(sampling.mean()), observed * math.sqrt(2.0 / (n - 1.0)), 1e-300)
    # a new machine differs by a Student variable with n − 1 degrees of freedom; the same variance
    return math.sqrt(between * (1.0 + 1.0 / n) * (n - 1.0) / (n - 3.0))


@dataclass(frozen=True)
class Posterior:
    """What own scores and a fleet say of a machine: nodes of s with weights, and normal m at each.

    Attributes
    ----------
    weights, deviations, means, errors : ndarray, shape (n_node,)
        Weight and value of s; mean and deviation of m.
    """

    weights: Array
    deviations: Array
    means: Array
    errors: Array

    def high(self, rate: float) -> float:
        """Limit that the next score exceeds with a probability."""
        from scipy.optimize import brentq
        from scipy.special import ndtr, ndtri

        spread = np.hypot(self.deviations, self.errors)
        ends = self.means - ndtri(rate) * spread
        if ends.min() == ends.max():
            return float(ends[0])
        excess = lambda limit: float(self.weights @ ndtr((self.means - limit) / spread)) - rate  # noqa: E731
        return float(brentq(excess, ends.min(), ends.max(), xtol=1e-12 * float(np.ptp(ends)), maxiter=500))

    def rate_interval(self, low: float, high: float, confidence: float) -> tuple[float, float]:
        """Interval of the true rate of scores beyond limits."""
        from scipy.special import ndtr, ndtri

        nodes = ndtri((np.arange(_N_MEAN) + 0.5) / _N_MEAN)
        means = self.means[:, None] + self.errors[:, None] * nodes
        spread = self.deviations[:, None]
        rates = np.ravel(ndtr((means - high) / spread) + ndtr((low - means) / spread))
        order = np.argsort(rates)
        below = np.cumsum(np.repeat(self.weights / _N_MEAN, _N_MEAN)[order])
        ends = np.searchsorted(below, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
        least, most = rates[order][np.minimum(ends, rates.size - 1)].tolist()
        return least, min(1.0, most)


def posterior(scores: ArrayLike, fleet: Fleet) -> Posterior:
    """What a machine of the fleet with some scores of its own is like.

    Parameters
    ----------
    scores : array_like, shape (n_score,)
        Own healthy scores, at least one.
    """
    own = np.asarray(scores, dtype=float)
    n, mean, dof = own.size, float(own.mean()), own.size - 1
    variance = float(own.var(ddof=1)) if dof else 0.0
    centre, width = fleet.log_deviation, fleet.log_deviation_deviation
    between, ends = fleet.mean_deviation**2, (centre - _REACH * width, centre + _REACH * width)
    # the grid is refined to the nodes with weight: many own scores leave a small part of the prior
    for _ in range(_N_GRID):
        logs = np.linspace(*ends, _N_SPREAD)
        squares = np.exp(2.0 * logs)
        total = between + squares / n
        log_weights = (
            -(((logs - centre) / width) ** 2) / 2.0
            - dof * (logs + variance / squares / 2.0)
            - np.log(total) / 2.0
            - (mean - fleet.mean) ** 2 / total / 2.0
        )
        weights = np.exp(log_weights - log_weights.max())
        known = weights > _LEAST_WEIGHT
        first, last = np.flatnonzero(known)[[0, -1]].tolist()
        ends = float(logs[max(first - 1, 0)]), float(logs[min(last + 1, _N_SPREAD - 1)])
    weights, shrinkage = weights[known], between / total[known]
    return Posterior(
        weights / weights.sum(),
        np.exp(logs[known]),
        fleet.mean + shrinkage * (mean - fleet.mean),
        np.sqrt(shrinkage * squares[known] / n),
    )


def fleet_limits(
    scores: NDArray[np.float64], fleet: Fleet, direction: Direction, rate: float, confidence: float
) -> tuple[Limits, Scale]:
    """Limits and healthy scale of a machine from its own scores and a fleet."""
    machine, each = posterior(scores, fleet), rate / direction.n_side
    turned = Posterior(machine.weights, machine.deviations, -machine.means, machine.errors)
    low = -math.inf if direction is Direction.RISING else -turned.high(each)
    high = math.inf if direction is Direction.FALLING else machine.high(each)
    centre, spread = float(machine.weights @ machine.means), float(machine.weights @ machine.deviations)
    limits = Limits(
        low=_finite(low),
        high=_finite(high),
        false_alarm_rate=rate,
        interval=machine.rate_interval(low, high, confidence),
        confidence=confidence,
        method="posterior predictive",
        interval_rests_on="fleet",
    )
    return limits, Scale(centre=centre, spread=spread, range=(float(scores.min()), float(scores.max())))


def own_limits(scored: HealthyScores, *, has_chart: bool, fleet: Fleet | None) -> tuple[Limits, Scale]:
    """Limits and healthy scale of a machine; with those of a fleet, if its own scores are too few."""
    config, own = scored.config, scored.scores
    try:
        limits, (centre, spread) = _limits_of(scored, has_chart=has_chart), healthy_scale(own)
    except NotStatedError:
        if fleet is None or config.threshold != "quantile":
            raise
        return fleet_limits(own, fleet, scored.direction, config.false_alarm_rate, config.confidence)
    return limits, Scale(centre=centre, spread=spread, range=(float(own.min()), float(own.max())))


def _limits_of(scored: HealthyScores, *, has_chart: bool) -> Limits:
    """Set the limits of a score.

    If records or groups have several windows each, the interval of the false-alarm rate is cross-validated:
    each record or group is tested with the limits of the others. Otherwise, or if too few windows remain
    without a record, windows are assumed independent and the interval follows from order statistics. If
    groups are stated, windows of a group are dependent, and too few groups are an error. With a chart, which
    alarms in place of the limits, too few windows are none: then the extreme healthy scores are the limits.
    """

    config, direction = scored.config, scored.direction

    def rule(scores: Array) -> Threshold:
        try:
            return config.set_threshold(scores, direction)
        except NotStatedError as refusal:
            if (needed := refusal.records_needed) is None:
                raise
            total = needed + scored.scores.size - scores.size
            raise NotStatedError(
                f"{str(refusal).partition(' needs ')[0]} needs {needed:,} healthy windows that do not"
                f" overlap ({time_text(needed * scored.duration)}), and there are {scores.size:,}"
                f"{'' if total == needed else f' without one of the groups, so {total:,} in all'}",
                needed,
            ) from None

    try:
        threshold = rule(scored.scores)
    except NotStatedError:
        if not has_chart:
            raise
        least = direction.n_side / (scored.scores.size + 1)
        config = config.model_copy(update={"false_alarm_rate": least, "threshold": "quantile"})
        threshold = rule(scored.scores)
    groups = scored.of_scores
    rests_on: Literal["windows", "records", "groups"] = "windows"
    interval = threshold.interval
    if 1 < np.unique(groups).size < groups.size:
        names: Any = groups
        try:
            outcomes = left_out_outcomes(scored.scores, names % _MOST_FOLDS, rule)
            rate = alarm_rate(outcomes, groups=names, confidence=threshold.confidence)
            rests_on, interval = "groups" if scored.has_groups else "records", (rate.low, rate.high)
        except NotStatedError:
            if scored.has_groups and not has_chart:
                raise
    return Limits(
        low=_finite(threshold.low),
        high=_finite(threshold.high),
        false_alarm_rate=config.false_alarm_rate,
        interval=interval,
        confidence=config.confidence,
        method=threshold.method,
        interval_rests_on=rests_on,
    )


def chart_of(scored: HealthyScores) -> TimedChart | None:
    """The chart that is asked for, with all options; the usual one if the records carry its promise.

    Its direction refers to scores that rise with leakage.
    """
    config, chart, usual = scored.config, scored.config.chart, TimedChart()
    if (
        "chart" not in config.model_fields_set
        and comparable(scored.hours * 3600.0) >= usual.false_alarm_every
    ):
        chart = usual
    if chart is None:
        return None
    turned = Direction.BOTH if scored.direction is Direction.BOTH else Direction.RISING
    made = make_chart(chart.chart, {"direction": turned, **chart.options})
    return chart.model_copy(update={"options": made.model_dump(mode="json")})


def chart_limit(scored: HealthyScores, chart: TimedChart, healthy: Scale) -> ChartLimit:
    """Limit that healthy scores, in time order, reach once within the required time on average."""
    starts = np.searchsorted(scored.record, range(1, len(scored.records)))
    lines = np.split(standardised(scored.all_scores, healthy, scored.direction), starts)
    groups: list[str] | None = None
    rests_on: Literal["pieces", "records", "groups"] = "pieces"
    if len(set(scored.groups)) >= FEWEST_GROUPS:
        groups, rests_on = scored.groups, "groups" if scored.has_groups else "records"
    else:
        length = max(1, sum(line.size for line in lines) // N_PIECE)
        lines = [line[first : first + length] for line in lines for first in range(0, line.size, length)]
    streams = np.full((len(lines), max(line.size for line in lines)), np.nan)
    for row, line in enumerate(lines):
        streams[row, : line.size] = line
    alarms = FalseAlarms(
        make_chart(chart.chart, chart.options), streams, scored.interval, groups=groups
    ).limit(chart.false_alarm_every, confidence=scored.config.confidence)
    return ChartLimit(
        limit=alarms.value,
        mean_time=_finite(alarms.mean_time),
        interval=(alarms.low, _finite(alarms.high)),
        hours=alarms.duration / 3600.0,
        rests_on=rests_on,
    )


_WARMER = 0.6
"""Growth of the flow through clearances with oil that is 15 K warmer, at 3 % less viscosity per kelvin."""


def with_allowance(
    limits: Limits, trained: TrainedScore | None, scored: HealthyScores
) -> tuple[Limits, TrainedScore | None]:
    """The limits of flows, which contain that of the valve clearances, with an allowance for warmer oil."""
    score = scored.config.score
    is_flow = scored.feature.described.unit == "m^3/s" and (score is None or score.kind == "either")
    warmer = _WARMER * float(np.nanmedian([each.clearance for each in scored.complete]))
    if not is_flow or limits.high is None or limits.low is not None or not warmer > 0.0:
        return limits, trained
    first, *others = (output.clearances[1] * warmer for _, output, _ in scored.feature.numbers.values())
    limits = limits.model_copy(update={"high": limits.high + first, "allowance": first})
    if trained is not None and others:
        rule, units = trained.rule, np.array(trained.rule["standardised"]["scale"])
        # another number has more room by its own share, less what the limit of the first gives it
        spread = units * rule["scale"]
        room = (np.array([first, *others]) - first * spread / spread[0]) / units
        rule = rule | {"coefficients": (np.array(rule["coefficients"]) + room[:, None]).tolist()}
        trained = trained.model_copy(update={"rule": rule})
    return limits, trained


def _finite(value: float) -> float | None:
    """The value; None if it is infinite."""
    return value if np.isfinite(value) else None
