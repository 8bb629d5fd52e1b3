"""The probability of detection of a score over the true severity, and the severities that are found."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from hydrofdi.evaluation.multiplicity import simultaneous_confidence
from hydrofdi.evaluation.pod.axis import AxisName
from hydrofdi.evaluation.pod.curve import PodCurve, probability_of_detection
from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.pod.lack_of_fit import LackOfFit, lack_of_fit
from hydrofdi.evaluation.pod.monotone import detected_level, last_shown
from hydrofdi.evaluation.pod.profile import quantile_of_chi_square
from hydrofdi.evaluation.pod.smallest import smallest_detectable
from hydrofdi.evaluation.pod.tally import Tally
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.evaluation.tolerance import records_needed
from hydrofdi.studies.parts import Notes, Part
from hydrofdi.studies.rules import Rules

SIGNIFICANCE = 0.05
"""A curve is not used where hits and misses as far from it come up less often."""


@dataclass(frozen=True)
class Detectability:
    """The curve, whether it holds, and the severities found (``q50``, ``q90``, ``q90_95``)."""

    curve: PodCurve | None = None
    lack_of_fit: LackOfFit | None = None
    smallest: Mapping[str, DetectableSeverity] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Tested:
    """Levels of a nominal severity, each with its largest true severity.

    The probability of detection there is at least the mean of the level, so what is stated is not too small.
    """

    levels: Sequence[Part]
    threshold: Threshold
    tally: Tally

    def lie_on_the_rise(self, curve: PodCurve) -> bool:
        """Whether two levels or more do, so that the curve has a slope.

        True severities of one level differ by little: what they tell of the slope is chance. A level whose
        severities span an octave counts as two.
        """
        floor, count = curve.false_alarm_rate, 0
        for level in self.levels:
            rise = (float(curve.probability(level.severity).mean()) - floor) / (1.0 - floor)
            span = level.severity.max() / level.severity.min()
            count += (1 + (span >= 2.0)) * (0.01 < rise < 0.99)
        return count >= 2

    def bound(self, probability: float, confidence: float) -> DetectableSeverity:
        """The last level whose one-sided limit of the rate of detection shows a probability."""
        rates = [level.rate(self.threshold, 2.0 * confidence - 1.0) for level in self.levels]
        shown = np.array([rate.low >= probability for rate in rates])
        n_group, needed = rates[-1].n_group, records_needed(1.0 - probability, confidence)
        if n_group is not None and n_group < needed and not shown[-1]:
            raise NotStatedError(
                f"a severity found with {probability:.3g} probability and {confidence:.5g} confidence needs"
                f" {needed} groups of faulty records that agree, not {n_group}",
                needed,
            )
        return last_shown(self.tally.severity, shown, probability, confidence)


def detectability(
    levels: Sequence[Part], threshold: Threshold, floor: float, rules: Rules, notes: Notes
) -> Detectability:
    """What faulty test records say of a score at its threshold.

    The curve is fitted over the true severities or their logarithms, whichever is the more likely. Where hits
    and misses are apart, where the curve does not describe them, and for bounds of records in groups, the
    nominal levels speak instead.

    Parameters
    ----------
    levels : sequence of Part
        Ascending in nominal severity.
    threshold : Threshold
    floor : float
        False-alarm rate, as measured.
    rules : Rules
    notes : Notes
        What is refused and remarked is added.
    """
    known = [level for level in map(_with_severity, levels) if level.scores.size]
    n_lost = sum(int(np.sum(~(level.severity >= 0.0))) for level in levels)
    if n_lost and known:
        notes.remarks.append(f"{n_lost} faulty records without a known severity are not in the curve")
    if not known:
        notes.refusals.append("no faulty record has a known severity: no probability of detection is stated")
        return Detectability()
    severity = np.concatenate([level.severity for level in known])
    outcomes = threshold.outcomes(np.concatenate([level.scores for level in known]))
    curves = notes.unless_refused(lambda: _curves(severity, outcomes, floor, rules))
    if curves is None:
        return Detectability()
    curve = curves[0]
    fit = lack_of_fit(curve)
    tested = _tested(known, threshold)
    return Detectability(curve, fit, _smallest(curves, fit, tested, _is_grouped(known), rules, notes))


def _curves(severity: Array, outcomes: Array, floor: float, rules: Rules) -> list[PodCurve]:
    """Along either axis, the likelier first."""
    axes: tuple[AxisName, ...] = ("log", "linear")
    curves = [
        probability_of_detection(severity, outcomes, false_alarm_rate=floor, link=rules.link, axis=axis)
        for axis in axes
    ]
    return sorted(curves, key=lambda curve: -curve.log_likelihood)


def _with_severity(level: Part) -> Part:
    is_known = (level.severity > 0.0) & np.isfinite(level.severity)
    groups = None
    if level.groups is not None:
        groups = [group for group, own in zip(level.groups, is_known, strict=True) if own]
    return Part(level.scores[is_known], level.severity[is_known], groups)


def _is_grouped(levels: Sequence[Part]) -> bool:
    return any(level.groups is not None for level in levels)


def _tested(levels: Sequence[Part], threshold: Threshold) -> _Tested:
    filled = [level for level in levels if not np.isnan(level.scores).all()]
    largest = [level.severity[~np.isnan(level.scores)].max() for level in filled]
    rates = [level.rate(threshold, 0.95) for level in filled]
    hits, total = (np.array([getattr(rate, name) for rate in rates], float) for name in ("count", "total"))
    return _Tested(filled, threshold, Tally(np.maximum.accumulate(largest), hits, total))


def _smallest(
    curves: Sequence[PodCurve], fit: LackOfFit, tested: _Tested, is_grouped: bool, rules: Rules, notes: Notes
) -> dict[str, DetectableSeverity]:
    curve, is_described = curves[0], not fit.p_value < SIGNIFICANCE
    if not is_described:
        notes.remarks.append(
            f"the curve of detection does not describe the hits and misses (p = {fit.p_value:.2g}): what is"
            " found is stated at the tested levels"
        )
    has_curve = is_described and not curve.is_step and tested.lie_on_the_rise(curve)
    found = {}
    for name, probability in (("q50", 0.5), ("q90", rules.probability)):
        if has_curve:
            found[name] = smallest_detectable(curve, probability=probability, confidence=None)
        else:
            found[name] = detected_level(tested.tally, probability=probability, confidence=None)
    confidences = {"q90_95": rules.confidence}
    if rules.n_tried > 1:
        confidences["q90_95_of_all"] = simultaneous_confidence(rules.confidence, rules.n_tried)
    for name, confidence in confidences.items():
        used = curves if has_curve and not is_grouped else ()
        bound = notes.unless_refused(partial(_bound, used, tested, rules.probability, confidence))
        found |= {} if bound is None else {name: bound}
    return found


def _bound(
    curves: Sequence[PodCurve], tested: _Tested, probability: float, confidence: float
) -> DetectableSeverity:
    """The bound from the curves, or from the tested levels where there are none."""
    needed = records_needed(1.0 - probability, confidence)
    n_record = int(tested.tally.total.sum() if curves else tested.tally.total[-1])
    if n_record < needed:
        where = "" if curves else " at the largest severity"
        raise NotStatedError(
            f"a severity found with {probability:.3g} probability and {confidence:.5g} confidence needs"
            f" {needed} faulty records{where}, not {n_record}",
            needed,
        )
    if not curves:
        return tested.bound(probability, confidence)
    bounds = [
        smallest_detectable(curve, probability=probability, confidence=confidence)
        for curve in _plausible(curves, confidence)
    ]
    return max(bounds, key=lambda bound: math.inf if bound.value is None else bound.severity)


def _plausible(curves: Sequence[PodCurve], confidence: float) -> list[PodCurve]:
    """Curves that the ratio of likelihoods does not reject; all are held against the likeliest."""
    largest = curves[0].log_likelihood
    drop = quantile_of_chi_square(2.0 * confidence - 1.0)
    return [
        replace(curve, log_likelihood=largest)
        for curve in curves
        if 2.0 * (largest - curve.log_likelihood) < drop and not curve.is_step
    ]
