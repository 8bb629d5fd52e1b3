"""Limits from healthy scores, and the confidence of their false-alarm rate."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Literal

import numpy as np

from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.file import Limits
from hydrofdi.detectors.trained.training.learned import Learned
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.rates import Rule, alarm_rate, left_out_outcomes
from hydrofdi.evaluation.threshold import Threshold, quantile_threshold, tolerance_threshold
from hydrofdi.records import Array
from hydrofdi.settings.readable import time_text

_MOST_FOLDS = 25
"""Maximum number of cross-validation folds; with more groups, several are left out at a time."""

RestsOn = Literal["windows", "records", "groups"]


def limits_of(learned: Learned, config: DetectorConfig, direction: Direction) -> Limits:
    """Set the limits of a score.

    If records or groups have several windows each, the interval of the false-alarm rate is cross-validated:
    each record or group is tested with the limits of the others. Otherwise, or if too few windows remain
    without a record, windows are assumed independent and the interval follows from order statistics. If
    groups are stated, windows of a group are dependent, and too few groups are an error.

    Raises
    ------
    NotStatedError
        There are too few windows; the message states how many are needed.
    """
    rule = _rule(config, direction)
    threshold = _set(rule, learned.scores, learned, "there are")
    rests_on, interval = _interval(rule, learned, threshold)
    return Limits(
        low=_known(threshold.low),
        high=_known(threshold.high),
        false_alarm_rate=config.false_alarm_rate,
        interval=interval,
        confidence=config.confidence,
        method=threshold.method,
        interval_rests_on=rests_on,
    )


def _rule(config: DetectorConfig, direction: Direction) -> Rule:
    kind = quantile_threshold if config.threshold == "quantile" else tolerance_threshold
    return partial(
        kind, false_alarm_rate=config.false_alarm_rate, direction=direction, confidence=config.confidence
    )


def _interval(rule: Rule, learned: Learned, threshold: Threshold) -> tuple[RestsOn, tuple[float, float]]:
    groups: Any = learned.of_scores
    n_group = np.unique(groups).size
    if n_group < 2 or n_group == groups.size:
        return "windows", threshold.interval
    found = "without one of the groups there are"
    try:
        outcomes = left_out_outcomes(
            learned.scores, groups % _MOST_FOLDS, lambda scores: _set(rule, scores, learned, found)
        )
    except NotStatedError:
        if learned.has_groups:
            raise
        return "windows", threshold.interval
    rate = alarm_rate(outcomes, groups=groups, confidence=threshold.confidence)
    return "groups" if learned.has_groups else "records", (rate.low, rate.high)


def _set(rule: Rule, scores: Array, learned: Learned, found: str) -> Threshold:
    try:
        return rule(scores)
    except NotStatedError as refusal:
        needed = refusal.records_needed
        if needed is None:
            raise
        promise = str(refusal).partition(" needs ")[0]
        what = "windows that do not overlap" if learned.n_sample else "estimates"
        lasting = time_text(needed * learned.duration)
        remedy = "more records, shorter windows" if learned.n_sample else "more records"
        raise NotStatedError(
            f"{promise} needs {needed:,} healthy {what} ({lasting}), and {found} {scores.size:,};"
            f" take {remedy} or a higher false_alarm_rate",
            needed,
        ) from None


def _known(limit: float) -> float | None:
    return limit if math.isfinite(limit) else None
