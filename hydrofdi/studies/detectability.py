"""Probability of detection of a score by true severity, and smallest detectable severities."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.multiplicity import simultaneous_confidence
from hydrofdi.evaluation.pod.curve import AxisName, LackOfFit, PodCurve, lack_of_fit, probability_of_detection
from hydrofdi.evaluation.pod.smallest import quantile_of_chi_square, smallest_detectable
from hydrofdi.evaluation.pod.tally import DetectableSeverity, interpolated_level
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold, records_needed
from hydrofdi.studies.parts import Notes, Part, TestedLevels, quantile_name
from hydrofdi.studies.rules import Rules

SIGNIFICANCE = 0.05
"""Significance level of the goodness-of-fit test: a curve with a smaller p-value is not used."""


@dataclass(frozen=True)
class Detectability:
    """Curve, goodness of fit, detectable severities (``q50`` …), and the curves of the bounds."""

    curve: PodCurve | None = None
    lack_of_fit: LackOfFit | None = None
    smallest: Mapping[str, DetectableSeverity] = field(default_factory=dict)
    bounding: tuple[PodCurve, ...] = ()


def detectability(
    levels: Sequence[Part], threshold: Threshold, floor: float, rules: Rules, notes: Notes
) -> Detectability:
    """Probability of detection from the faulty test records of a score at its threshold.

    The curve is fitted over true severities or their logarithms, whichever has the larger likelihood. If hits
    and misses are separated, or the curve does not fit, results come from the nominal levels; so do bounds of
    records in groups.

    Parameters
    ----------
    levels : sequence of Part
        Levels, ascending in nominal severity.
    threshold : Threshold
    floor : float
        Measured false-alarm rate.
    rules : Rules
    notes : Notes
        Refusals and remarks are added to it.
    """
    known = [level for level in map(_with_severity, levels) if level.scores.size]
    n_lost = sum(int(np.sum(~(level.severity >= 0.0))) for level in levels)
    if n_lost and known:
        notes.remarks.append(f"{n_lost} faulty records without a known severity are not in the curve")
    if not known:
        notes.refusals.append("no faulty record has a known severity: there is no probability of detection")
        return Detectability()
    if all(np.isnan(level.scores).all() for level in known):
        notes.refusals.append("no faulty record has a score: there is no probability of detection")
        return Detectability()
    tested = TestedLevels(known, threshold)
    if floor >= 1.0:
        notes.refusals.append(
            "every healthy test record raises an alarm: there is no probability of detection"
        )
        return Detectability()
    curves = _curves(tested, tested.outcomes, floor, rules)
    fit = lack_of_fit(curves[0])
    is_described = not fit.p_value < SIGNIFICANCE
    has_curve = is_described and tested.lie_on_the_rise(curves[0])
    used: Sequence[PodCurve] = ()
    if not tested.is_grouped and is_described:
        used = curves if has_curve else _with_one_miss_more(curves[0], tested, rules)
    smallest = _smallest(curves[0] if has_curve else None, used, tested, rules, notes)
    if not has_curve:
        notes.remarks.append(f"{_why_no_curve(fit, is_described)}: {_where_from(smallest, rules)}")
    return Detectability(curves[0], fit, smallest, tuple(_plausible(used, rules.confidence)))


def _why_no_curve(fit: LackOfFit, is_described: bool) -> str:
    return (
        "fewer than two tested levels lie on the slope of the curve of detection"
        if is_described
        else f"the curve of detection does not describe the hits and misses (p = {fit.p_value:.2g})"
    )


def _where_from(smallest: Mapping[str, DetectableSeverity], rules: Rules) -> str:
    """Where the severities come from without a curve of the records as they are."""
    of_curve = {name for name, found in smallest.items() if found.source == "curve"}
    if "q90_95" not in of_curve:
        return "results come from the tested levels"
    bound = quantile_name(rules.probability, rules.confidence)
    if "q90" in of_curve:
        return f"{bound} and the estimates are those of the curve with one more miss"
    return f"{bound} is that of the curve with one more miss, the estimates come from the tested levels"


def _curves(tested: TestedLevels, outcomes: Array, floor: float, rules: Rules) -> list[PodCurve]:
    """Curves on both axes, the more likely first."""
    axes: tuple[AxisName, ...] = ("log", "linear")
    curves = [
        probability_of_detection(
            tested.severity, outcomes, false_alarm_rate=floor, link=rules.link, axis=axis
        )
        for axis in axes
    ]
    return sorted(curves, key=lambda curve: -curve.log_likelihood)


def _with_severity(level: Part) -> Part:
    is_known = (level.severity > 0.0) & np.isfinite(level.severity)
    groups = None
    if level.groups is not None:
        groups = [group for group, own in zip(level.groups, is_known, strict=True) if own]
    return Part(level.scores[is_known], level.severity[is_known], groups)


def _smallest(
    curve: PodCurve | None, used: Sequence[PodCurve], tested: TestedLevels, rules: Rules, notes: Notes
) -> dict[str, DetectableSeverity]:
    """Estimates from the curve, or else from the levels; bounds from the curves that are used."""
    confidences = {"q90_95": rules.confidence}
    if rules.n_tried > 1:
        confidences["q90_95_of_all"] = simultaneous_confidence(rules.confidence, rules.n_tried)
    bounds: dict[str, DetectableSeverity] = {}
    for name, confidence in confidences.items():
        bound = notes.unless_refused(
            partial(_bound, used, tested, rules.probability, confidence, is_sure=curve is not None)
        )
        bounds |= {} if bound is None else {name: bound}
    estimates = _estimates(curve, tested, rules)
    bound = bounds.get("q90_95")
    if bound is not None and _upper(estimates["q90"]) > _upper(bound):
        estimates = _estimates(used[0] if bound.source == "curve" else None, tested, rules)
    return estimates | bounds


def _estimates(curve: PodCurve | None, tested: TestedLevels, rules: Rules) -> dict[str, DetectableSeverity]:
    """``q50`` and ``q90`` of a curve, or else interpolated between the tested levels."""
    return {
        name: interpolated_level(tested.tally, probability=probability)
        if curve is None
        else smallest_detectable(curve, probability=probability, confidence=None)
        for name, probability in (("q50", 0.5), ("q90", rules.probability))
    }


def _with_one_miss_more(curve: PodCurve, tested: TestedLevels, rules: Rules) -> Sequence[PodCurve]:
    """Curves fitted with one detection fewer; none if these have no slope either.

    More hits never worsen a bound, so the bound of these curves is valid.
    """
    outcomes = tested.with_one_miss_more()
    if outcomes is None:
        return ()
    curves = _curves(tested, outcomes, curve.false_alarm_rate, rules)
    is_described = not lack_of_fit(curves[0]).p_value < SIGNIFICANCE
    return curves if is_described and tested.lie_on_the_rise(curves[0]) else ()


def _bound(
    curves: Sequence[PodCurve],
    tested: TestedLevels,
    probability: float,
    confidence: float,
    *,
    is_sure: bool,
) -> DetectableSeverity:
    """Bound from the curves; if these were fitted with one miss more, at most the bound from the levels."""
    needed = records_needed(1.0 - probability, confidence)
    n_record = int(tested.tally.total.sum() if curves else tested.tally.total[-1])
    if n_record < needed:
        where = "" if curves else " at the largest severity"
        raise NotStatedError(
            f"{quantile_name(probability, confidence)} needs {needed} faulty records{where}; there are"
            f" {n_record}",
            needed,
        )
    bounds = [
        smallest_detectable(curve, probability=probability, confidence=confidence)
        for curve in _plausible(curves, confidence)
    ]
    of_curves = [max(bounds, key=_upper)] if bounds else []
    if of_curves and is_sure:
        return of_curves[0]
    return min((tested.bound(probability, confidence), *of_curves), key=_upper)


def _upper(bound: DetectableSeverity) -> float:
    return math.inf if bound.value is None else bound.value


def _plausible(curves: Sequence[PodCurve], confidence: float) -> list[PodCurve]:
    """Curves that the likelihood ratio against the most likely one does not reject."""
    if not curves:
        return []
    largest = curves[0].log_likelihood
    drop = quantile_of_chi_square(2.0 * confidence - 1.0)
    return [
        replace(curve, log_likelihood=largest)
        for curve in curves
        if 2.0 * (largest - curve.log_likelihood) < drop and not curve.is_step
    ]
