"""Limits of scores and charts from healthy records."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from hydrofdi.detectors.charts import FalseAlarms
from hydrofdi.detectors.configuration import TimedChart
from hydrofdi.detectors.file import ChartLimit, Limits, Scale, TrainedScore
from hydrofdi.detectors.rules import make_chart
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


def limits_of(scored: HealthyScores, *, has_chart: bool) -> Limits:
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
