"""Evaluation of a score as a detector: settings from fit records, results from test records."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from hydrofdi.detectors.rules import Rules
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation import pod, rates
from hydrofdi.evaluation.scores import Array, Direction, Kind, Population, comparable, suspicion
from hydrofdi.evaluation.threshold import Threshold, records_needed
from hydrofdi.studies.records import SOUND, Judgement, Notes, Outcome, Part, Scored, StudyRecords, part

Reference = tuple[Part, Array | None, Callable[[Array], Array]]


def reference_of(records: StudyRecords, scored: Scored, direction: Direction) -> Reference:
    """Healthy records for ROC curves, their suspicion (None without fit scores), and that of other scores.

    Healthy test records, or the fit records if there are none; both directions are judged from the median of
    the fit records.
    """
    fit = part(records, scored, records.chosen(Kind.HEALTHY, is_fit=True))
    tested = records.chosen(Kind.HEALTHY, is_fit=False)
    healthy, known = part(records, scored, tested) if tested else fit, fit.scores[~np.isnan(fit.scores)]
    centre = float(np.median(known)) if known.size else math.nan
    of = partial(suspicion, direction=direction, centre=centre)
    return healthy, of(healthy.scores) if np.isfinite(centre) else None, of


def judge(records: StudyRecords, scored: Scored, rules: Rules, *, n_tried: int = 1) -> Judgement:
    """Evaluate a score as a detector.

    Direction, healthy reference and threshold come only from fit records. If there are groups but no healthy
    test records, each healthy group is tested at the threshold of the others. Detections are only stated if
    the false-alarm rate was measured.
    """
    case = _Case(records=records, scored=scored, rules=rules)
    fit = case.part(records.chosen(Kind.HEALTHY, is_fit=True))
    direction = case.direction(fit)
    threshold = case.unless_refused(lambda: rules.set_threshold(fit.scores, direction))
    false_alarms = {} if threshold is None else case.false_alarms(threshold, direction)
    floor = None if threshold is None else case.floor(false_alarms)
    stated = None if floor is None else threshold
    faulty = {each: case.part([each]) for each in records.chosen(Kind.FAULT, is_fit=False)}
    reference, outcomes = reference_of(records, scored, direction), list[Outcome[rates.Rate | None]]()
    for population, rate in false_alarms.items():
        is_counted = rate.total < rules.records_for_false_alarms
        outcomes.append(Outcome(population, 0.0, rate, is_counted=is_counted))
    for population, own in faulty.items():
        detected = None if stated is None else own.detected(stated, rules.confidence)
        is_counted = detected is not None and detected.total < rules.records_for_detection
        severity = float(own.severity.mean()) if own.severity.size else math.nan
        outcomes.append(Outcome(population, severity, detected, case.area(own, reference), is_counted))
    found: dict[str, Any] = {}
    if stated is not None and floor is not None and faulty:
        found = detectability(list(faulty.values()), stated, floor, rules, case, n_tried)
    case.remark(fit, faulty)
    return Judgement(
        scored=scored,
        direction=direction,
        threshold=threshold,
        outcomes=tuple(outcomes),
        healthy_pairs=case.healthy_pairs(fit, direction),
        refusals=tuple(dict.fromkeys(case.refusals)),
        remarks=tuple(dict.fromkeys(case.remarks)),
        **found,
    )


@dataclass(eq=False, kw_only=True)
class _Case(Notes):
    """The score under evaluation and its remarks."""

    records: StudyRecords
    scored: Scored
    rules: Rules

    def part(self, populations: Collection[Population]) -> Part:
        return part(self.records, self.scored, populations)

    def area(self, faulty: Part, reference: Reference) -> rates.Area | None:
        """Area under the ROC curve against the healthy records; over groups if there are enough of them."""
        healthy, below, of = reference
        if below is None or not faulty.scores.size:
            return None
        state: Callable[..., rates.Area] = rates.area_under_curve
        if healthy.groups is not None and faulty.groups is not None:
            if len({*healthy.groups, *faulty.groups}) >= rates.FEWEST_GROUPS:
                of_healthy, of_faulty = healthy.groups, faulty.groups
                state = partial(rates.grouped_area, healthy_groups=of_healthy, faulty_groups=of_faulty)
            else:
                self.remarks.append(
                    f"fewer than {rates.FEWEST_GROUPS} groups: intervals of areas assume independent records,"
                    " and are too short"
                )
        return self.unless_refused(lambda: state(below, of(faulty.scores), confidence=self.rules.confidence))

    def direction(self, fit: Part) -> Direction:
        if self.scored.direction is not None:
            return self.scored.direction
        faulty = self.part(self.records.chosen(Kind.FAULT, is_fit=True)).scores
        learned = None
        if faulty.size:
            learned = self.unless_refused(
                lambda: rates.learned_direction(fit.scores, faulty, confidence=self.rules.confidence)
            )
        if learned is None:
            self.remarks.append(
                "neither its definition nor faulty fit records determine its direction: both directions alarm"
            )
        return learned or Direction.BOTH

    def false_alarms(self, threshold: Threshold, direction: Direction) -> dict[Population, rates.Rate]:
        """The rates of all records without the fault that did not set the threshold."""
        tested = [population for kind in SOUND for population in self.records.chosen(kind, is_fit=False)]
        stated = {each: self.part([each]).rate(threshold, self.rules.confidence) for each in tested}
        if not any(population.kind is Kind.HEALTHY for population in tested):
            stated = self._left_out(direction) | stated
        return stated

    def _left_out(self, direction: Direction) -> dict[Population, rates.Rate]:
        """The rate of healthy fit records, each group at the threshold of the others."""
        rule, stated = partial(self._threshold_of_others, direction=direction), dict[Population, rates.Rate]()
        for population in self.records.chosen(Kind.HEALTHY, is_fit=True):
            own = self.part([population])
            if own.groups is None:
                continue
            outcomes = self.unless_refused(partial(rates.left_out_outcomes, own.scores, own.groups, rule))
            if outcomes is not None:
                stated[population] = rates.alarm_rate(
                    outcomes, groups=own.groups, confidence=self.rules.confidence
                )
        if stated:
            self.remarks.append("each healthy group is tested at the threshold of the other healthy groups")
        return stated

    def _threshold_of_others(self, scores: Array, direction: Direction) -> Threshold:
        try:
            return self.rules.set_threshold(scores, direction)
        except NotStatedError as refusal:
            reason = f"to test a healthy group, the others set the threshold: {refusal}"
            raise NotStatedError(reason, refusal.records_needed) from None

    def healthy_pairs(self, fit: Part, direction: Direction) -> tuple[rates.HealthyPair, ...]:
        """Every healthy group of labelled records against every other."""
        if not self.records.is_labelled or fit.groups is None or len(set(fit.groups)) < 2:
            return ()
        rule = partial(self.rules.set_threshold, direction=direction)
        return rates.healthy_against_healthy(fit.scores, fit.groups, rule, confidence=self.rules.confidence)

    def floor(self, false_alarms: Mapping[Population, rates.Rate]) -> float | None:
        """False-alarm rate measured on healthy records; None if no healthy record was tested."""
        healthy = [rate for each, rate in false_alarms.items() if each.kind is Kind.HEALTHY and rate.total]
        if not healthy:
            self.refusals.append(
                "no healthy record was tested, so the false-alarm rate is unknown and detections are not"
                " stated"
            )
            return None
        return sum(rate.count for rate in healthy) / sum(rate.total for rate in healthy)

    def remark(self, fit: Part, faulty: Mapping[Population, Part]) -> None:
        """Add remarks if faulty records are missed, and if records look like one counted several times."""
        missing = [
            f"{own.n_missing} of {own.scores.size} at {population.name!r}"
            for population, own in faulty.items()
            if own.n_missing
        ]
        if missing:
            self.remarks.append(
                f"faulty records without a score raise no alarm and count as missed: {', '.join(missing)}"
            )
        known = fit.scores[~np.isnan(fit.scores)]
        if known.size > 1 and np.all(known == known[0]):
            self.remarks.append(
                f"all {known.size} healthy fit records have the same score: rates and intervals hold for"
                " independent records, and these may be one record"
            )


def quantile_name(probability: float, confidence: float) -> str:
    """Name such as ``q90/95``: detected with 90 % probability at 95 % confidence."""
    return f"q{100.0 * probability:.5g}/{rates.confidence_text(confidence)}"


SIGNIFICANCE = 0.05
"""Significance level of the goodness-of-fit test: a curve with a smaller p-value is not used."""


@dataclass(frozen=True, eq=False)
class TestedLevels:
    """Levels of nominal severity, ascending; all true severities are known.

    A record without a score raises no alarm, so it counts as a miss.
    """

    levels: Sequence[Part]
    threshold: Threshold

    @cached_property
    def severity(self) -> Array:
        """True severity of each record, shape (n_record,)."""
        return np.concatenate([level.severity for level in self.levels])

    @cached_property
    def outcomes(self) -> Array:
        """1 if detected, 0 if not, shape (n_record,)."""
        return np.concatenate([level.detections(self.threshold) for level in self.levels])

    @cached_property
    def tally(self) -> pod.HitCount:
        """Hits of each level at its *largest* true severity.

        The probability of detection there is at least the mean of the level, so detectable severities are not
        too small.
        """
        detected = [level.detected(self.threshold, 0.95) for level in self.levels]
        hits, total = (
            np.array([getattr(rate, name) for rate in detected], float) for name in ("count", "total")
        )
        largest = [level.severity.max() for level in self.levels]
        return pod.HitCount(np.maximum.accumulate(largest), hits, total)

    def lie_on_the_rise(self, curve: pod.PodCurve) -> bool:
        """Whether at least two levels lie on the slope of the curve.

        True severities within a level differ too little to determine a slope. A level whose severities span
        an octave counts as two.
        """
        if curve.is_step:
            return False
        floor, count = curve.false_alarm_rate, 0
        for level in self.levels:
            rise = (float(curve.probability(level.severity).mean()) - floor) / (1.0 - floor)
            span = level.severity.max() / level.severity.min()
            count += (1 + bool(comparable(span) >= 2.0)) * (0.01 < round(rise, 6) < 0.99)
        return count >= 2

    def curves(self, outcomes: Array, floor: float) -> list[pod.PodCurve]:
        """Curves on both axes, the more likely first; two levels have the same likelihood on both."""
        axes: tuple[pod.AxisName, ...] = ("log", "linear")
        log, linear = (
            pod.probability_of_detection(self.severity, outcomes, false_alarm_rate=floor, axis=axis)
            for axis in axes
        )
        return [log, linear] if log.log_likelihood >= linear.log_likelihood - 1e-6 else [linear, log]

    def curves_with_one_miss_more(self, floor: float) -> list[pod.PodCurve]:
        """Curves fitted with one detection fewer; none if these have no slope either.

        It is the one at the largest severity of the smallest level that is always detected. More hits never
        worsen a bound, so the bound of these curves is valid.
        """
        outcomes, first = self.outcomes.copy(), 0
        for level, misses in zip(self.levels, self.tally.misses, strict=True):
            if not misses:
                outcomes[first + int(np.argmax(level.severity))] = 0.0
                curves = self.curves(outcomes, floor)
                is_described = not pod.lack_of_fit(curves[0]) < SIGNIFICANCE
                return curves if is_described and self.lie_on_the_rise(curves[0]) else []
            first += level.severity.size
        return []

    def estimates(self, curve: pod.PodCurve | None, probability: float) -> dict[str, pod.DetectableSeverity]:
        """``q50`` and ``q90`` of a curve, or else interpolated between the levels."""
        return {
            name: pod.interpolated_level(self.tally, probability=share)
            if curve is None
            else pod.smallest_detectable(curve, probability=share, confidence=None)
            for name, share in (("q50", 0.5), ("q90", probability))
        }

    def bound(
        self, probability: float, confidence: float, curves: Sequence[pod.PodCurve], *, is_sure: bool
    ) -> pod.DetectableSeverity:
        """Bound from the curves; if these are not sure, at most the bound from the levels."""
        needed = records_needed(1.0 - probability, confidence)
        n_record = int(self.tally.total.sum() if curves else self.tally.total[-1])
        if n_record < needed:
            where = "" if curves else " at the largest severity"
            raise NotStatedError(
                f"{quantile_name(probability, confidence)} needs {needed} faulty records{where}; there are"
                f" {n_record}",
                needed,
            )
        bounds = [
            pod.smallest_detectable(curve, probability=probability, confidence=confidence)
            for curve in _plausible(curves, confidence)
        ]
        of_curves = [max(bounds, key=_upper)] if bounds else []
        if of_curves and is_sure:
            return of_curves[0]
        return min((self.bound_of_levels(probability, confidence), *of_curves), key=_upper)

    def bound_of_levels(self, probability: float, confidence: float) -> pod.DetectableSeverity:
        """Last level whose one-sided limit of the detection rate meets a probability."""
        detected = [level.detected(self.threshold, 2.0 * confidence - 1.0) for level in self.levels]
        shown = np.array([comparable(rate.low) >= comparable(probability) for rate in detected])
        n_group, needed = detected[-1].n_group, records_needed(1.0 - probability, confidence)
        if n_group is not None and n_group < needed and not shown[-1]:
            raise NotStatedError(
                f"{quantile_name(probability, confidence)} needs {needed} groups of faulty records that"
                f" agree; there are {n_group}",
                needed,
            )
        return pod.last_shown(self.tally.severity, shown, probability, confidence)


def detectability(
    levels: Sequence[Part], threshold: Threshold, floor: float, rules: Rules, notes: Notes, n_tried: int = 1
) -> dict[str, Any]:
    """Probability of detection from the faulty test records of a score at its threshold.

    The curve is fitted over true severities or their logarithms, whichever has the larger likelihood. If hits
    and misses are separated, or the curve does not fit, results come from the nominal levels; so do bounds of
    records in groups.

    Returns
    -------
    dict
        ``curve``, ``lack_of_fit``, ``smallest`` and ``bounding`` of a `Judgement`; empty if refused.
    """
    known = [level for level in map(_with_severity, levels) if level.scores.size]
    n_lost = sum(int(np.sum(~(level.severity >= 0.0))) for level in levels)
    if n_lost and known:
        notes.remarks.append(f"{n_lost} faulty records without a known severity are not in the curve")
    refusals = {
        "no faulty record has a known severity": not known,
        "no faulty record has a score": all(np.isnan(level.scores).all() for level in known),
        "every healthy test record raises an alarm": floor >= 1.0,
    }
    for why in (why for why, is_so in refusals.items() if is_so):
        notes.refusals.append(f"{why}: there is no probability of detection")
        return {}
    tested = TestedLevels(known, threshold)
    curves = tested.curves(tested.outcomes, floor)
    fit = pod.lack_of_fit(curves[0])
    is_described = not fit < SIGNIFICANCE
    has_curve = is_described and tested.lie_on_the_rise(curves[0])
    used: Sequence[pod.PodCurve] = ()
    if is_described and all(level.groups is None for level in known):
        used = curves if has_curve else tested.curves_with_one_miss_more(floor)
    confidences = {"q90_95": rules.confidence}
    if n_tried > 1:
        confidences["q90_95_of_all"] = rates.simultaneous_confidence(rules.confidence, n_tried)
    bounds: dict[str, pod.DetectableSeverity] = {}
    for name, confidence in confidences.items():
        stated = partial(tested.bound, rules.probability, confidence, used, is_sure=has_curve)
        if (bound := notes.unless_refused(stated)) is not None:
            bounds[name] = bound
    estimates = tested.estimates(curves[0] if has_curve else None, rules.probability)
    bound = bounds.get("q90_95")
    if bound is not None and _upper(estimates["q90"]) > _upper(bound):
        estimates = tested.estimates(used[0] if bound.source == "curve" else None, rules.probability)
    if not has_curve:
        why = "fewer than two tested levels lie on the slope of the curve of detection"
        if not is_described:
            why = f"the curve of detection does not describe the hits and misses (p = {fit:.2g})"
        notes.remarks.append(f"{why}: severities come from tested levels, or a curve with one more miss")
    bounding = tuple(_plausible(used, rules.confidence))
    found = {"curve": curves[0], "lack_of_fit": fit, "bounding": bounding}
    return {**found, "smallest": estimates | bounds}


def _with_severity(level: Part) -> Part:
    rows = np.flatnonzero((level.severity > 0.0) & np.isfinite(level.severity))
    groups = None if level.groups is None else [level.groups[row] for row in rows]
    return Part(level.scores[rows], level.severity[rows], groups)


def _upper(bound: pod.DetectableSeverity) -> float:
    return math.inf if bound.value is None else bound.value


def _plausible(curves: Sequence[pod.PodCurve], confidence: float) -> list[pod.PodCurve]:
    """Curves that the likelihood ratio against the most likely one does not reject."""
    if not curves:
        return []
    largest = curves[0].log_likelihood
    drop = pod.quantile_of_chi_square(2.0 * confidence - 1.0)
    return [
        replace(curve, log_likelihood=largest)
        for curve in curves
        if 2.0 * (largest - curve.log_likelihood) < drop and not curve.is_step
    ]
