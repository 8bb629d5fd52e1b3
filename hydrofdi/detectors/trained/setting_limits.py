"""Healthy scores → limits, and what their promise rests on."""

from __future__ import annotations

import math
from functools import partial
from typing import Literal

import numpy as np

from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.file import Limits
from hydrofdi.detectors.trained.learned import Learned
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.groups import Rule, left_out_outcomes
from hydrofdi.evaluation.rates import alarm_rate
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.threshold import Threshold, quantile_threshold
from hydrofdi.evaluation.tolerance import tolerance_threshold

_MOST_FOLDS = 25
"""More groups than these are left out several at a time."""

RestsOn = Literal["windows", "records", "groups"]


def limits_of(learned: Learned, config: DetectorConfig, direction: Direction) -> Limits:
    """The limits of a score.

    Where records or groups give several windows each, the interval of the rate is that of left-out records or
    groups: each meets the limits of the others. Else windows are taken as independent, and the interval
    follows from order statistics.

    Raises
    ------
    NotStatedError
        Too few windows; it tells how many are needed.
    """
    rule = _rule(config, direction)
    scores = learned.scores
    names = np.asarray(learned.of_scores)
    threshold = _set(rule, scores, f"and there are {scores.size:,}")
    rests_on, interval = _interval(rule, scores, names, threshold, learned.has_groups)
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


def _interval(
    rule: Rule, scores: np.ndarray, names: np.ndarray, threshold: Threshold, has_groups: bool
) -> tuple[RestsOn, tuple[float, float]]:
    distinct, places = np.unique(names, return_inverse=True)
    if distinct.size < 2 or distinct.size == scores.size:
        return "windows", threshold.interval
    what: RestsOn = "groups" if has_groups else "records"
    folds = (places % _MOST_FOLDS).astype(str)
    most = max(np.unique(folds, return_counts=True)[1])
    found = f"and without the largest of the {what} there are {scores.size - most:,}"

    def outcomes(others: np.ndarray) -> Threshold:
        return _set(rule, others, found)

    left_out = left_out_outcomes(scores, folds.tolist(), outcomes)
    rate = alarm_rate(left_out, groups=names.tolist(), confidence=threshold.confidence)
    return what, (rate.low, rate.high)


def _set(rule: Rule, scores: np.ndarray, found: str) -> Threshold:
    try:
        return rule(scores)
    except NotStatedError as refusal:
        if refusal.records_needed is None:
            raise
        text = str(refusal).partition(" needs ")[0]
        raise NotStatedError(
            f"{text} needs {refusal.records_needed:,} healthy windows that do not overlap, {found}",
            refusal.records_needed,
        ) from None


def _known(limit: float) -> float | None:
    return limit if math.isfinite(limit) else None
