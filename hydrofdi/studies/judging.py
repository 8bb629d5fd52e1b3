"""Evaluation of a score as a detector: settings from fit records, results from test records."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction, learned_direction, suspicion
from hydrofdi.evaluation.grouped_area import FEWEST_GROUPS, MANY_GROUPS, clustered_area, grouped_area
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.rates import Rate, alarm_rate, left_out_outcomes
from hydrofdi.evaluation.roc import Area, area_under_curve, roc_curve
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.studies.detectability import Detectability, detectability
from hydrofdi.studies.judgement import Judgement, Level
from hydrofdi.studies.parts import Notes, Part, part
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.studies.rules import Rules


@dataclass(frozen=True, eq=False)
class Suspicion:
    """Transformation of scores so that larger is more suspicious, and the healthy records for comparison.

    Attributes
    ----------
    healthy : Part
    direction : Direction
    centre : float
        Healthy reference value for both directions: the median of the fit records.
    rules : Rules
    """

    healthy: Part
    direction: Direction
    centre: float
    rules: Rules

    def of(self, part: Part) -> Array:
        """Transformed scores, larger is more suspicious, shape (n_record,)."""
        return suspicion(part.scores, self.direction, self.centre)

    def area(self, faulty: Part, notes: Notes) -> Area | None:
        """Area under the ROC curve against the healthy records.

        Its interval is over groups if there are enough of them.
        """
        healthy, confidence = self.healthy, self.rules.confidence
        if not (np.isfinite(self.centre) and faulty.scores.size):
            return None
        if healthy.groups is not None and faulty.groups is not None:
            groups = healthy.groups, faulty.groups
            n_group = len({*healthy.groups, *faulty.groups})
            if n_group >= FEWEST_GROUPS:
                over_groups = clustered_area if n_group >= MANY_GROUPS else grouped_area
                return notes.unless_refused(
                    lambda: over_groups(self.of(healthy), self.of(faulty), *groups, confidence=confidence)
                )
            notes.remarks.append(
                f"fewer than {FEWEST_GROUPS} groups: intervals of areas assume independent records, and are"
                " too short"
            )
        return notes.unless_refused(
            lambda: area_under_curve(self.of(healthy), self.of(faulty), confidence=confidence)
        )

    def partial_area(self, faulty: Part) -> float:
        """Scaled partial area up to the false-alarm rate; NaN without scores of both kinds."""
        if not np.isfinite(self.centre):
            return math.nan
        try:
            curve = roc_curve(self.of(self.healthy), self.of(faulty))
        except NotStatedError:
            return math.nan
        return curve.partial_area(self.rules.false_alarm_rate)


def suspicion_from(fit: Part, healthy: Part, direction: Direction, rules: Rules) -> Suspicion:
    """`Suspicion` defined by the healthy fit records."""
    known = fit.scores[~np.isnan(fit.scores)]
    return Suspicion(healthy, direction, float(np.median(known)) if known.size else math.nan, rules)


def judge(records: StudyRecords, scored: Scored, rules: Rules) -> Judgement:
    """Evaluate a score as a detector.

    Direction, healthy reference and threshold come only from fit records. If there are groups but no healthy
    test records, each healthy group is tested at the threshold of the others. Detections are only stated if
    the false-alarm rate was measured.

    Parameters
    ----------
    records : StudyRecords
    scored : Scored
        Score whose values were computed without labels or severities.
    rules : Rules
    """
    case = _Case(records, scored, rules, Notes())
    fit = case.part(records.chosen(Kind.HEALTHY, is_fit=True))
    direction = case.direction(fit)
    threshold = case.notes.unless_refused(lambda: rules.set_threshold(fit.scores, direction))
    false_alarms = {} if threshold is None else case.false_alarms(threshold, direction)
    floor = None if threshold is None else case.floor(false_alarms)
    stated = None if floor is None else threshold
    faulty = {each: case.part([each]) for each in records.chosen(Kind.FAULT, is_fit=False)}
    tested = records.chosen(Kind.HEALTHY, is_fit=False)
    suspicion = suspicion_from(fit, case.part(tested) if tested else fit, direction, rules)
    levels = tuple(
        Level(
            population,
            float(own.severity.mean()) if own.severity.size else np.nan,
            None if stated is None else own.detected(stated, rules.confidence),
            suspicion.area(own, case.notes),
        )
        for population, own in faulty.items()
    )
    found = Detectability()
    if stated is not None and floor is not None and faulty:
        found = detectability(list(faulty.values()), stated, floor, rules, case.notes)
    case.remark_missing(fit, faulty)
    case.remark_equal(fit)
    return Judgement(
        scored=scored,
        direction=direction,
        threshold=threshold,
        false_alarms=false_alarms,
        levels=levels,
        curve=found.curve,
        lack_of_fit=found.lack_of_fit,
        bounding=found.bounding,
        smallest=found.smallest,
        partial_area=suspicion.partial_area(case.part(list(faulty))),
        counted=_counted(false_alarms, levels, rules),
        refusals=tuple(dict.fromkeys(case.notes.refusals)),
        remarks=tuple(dict.fromkeys(case.notes.remarks)),
    )


@dataclass(frozen=True, eq=False)
class _Case:
    """The score under evaluation and its remarks."""

    records: StudyRecords
    scored: Scored
    rules: Rules
    notes: Notes

    def part(self, populations: Collection[Population]) -> Part:
        return part(self.records, self.scored, populations)

    def direction(self, fit: Part) -> Direction:
        if self.scored.direction is not None:
            return self.scored.direction
        faulty = self.part(self.records.chosen(Kind.FAULT, is_fit=True)).scores
        learned = None
        if faulty.size:
            learned = self.notes.unless_refused(
                lambda: learned_direction(fit.scores, faulty, confidence=self.rules.confidence)
            )
        if learned is None:
            self.notes.remarks.append(
                "neither its definition nor faulty fit records determine its direction: both directions alarm"
            )
        return learned or Direction.BOTH

    def false_alarms(self, threshold: Threshold, direction: Direction) -> dict[Population, Rate]:
        """The rates of all records without the fault that did not set the threshold."""
        tested = [
            population
            for kind in (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)
            for population in self.records.chosen(kind, is_fit=False)
        ]
        confidence = self.rules.confidence
        rates = {population: self.part([population]).rate(threshold, confidence) for population in tested}
        if not any(population.kind is Kind.HEALTHY for population in tested):
            rates = self._left_out(direction) | rates
        for population, rate in rates.items():
            if population.kind is Kind.HEALTHY and rate.total:
                self._remark_excluded(population, rate)
        return rates

    def _left_out(self, direction: Direction) -> dict[Population, Rate]:
        """The rate of healthy fit records, each group at the threshold of the others."""
        rule, rates = partial(self._threshold_of_others, direction=direction), dict[Population, Rate]()
        for population in self.records.chosen(Kind.HEALTHY, is_fit=True):
            own = self.part([population])
            if own.groups is None:
                continue
            outcomes = self.notes.unless_refused(partial(left_out_outcomes, own.scores, own.groups, rule))
            if outcomes is not None:
                confidence = self.rules.confidence
                rates[population] = alarm_rate(outcomes, groups=own.groups, confidence=confidence)
        if rates:
            self.notes.remarks.append(
                "each healthy group is tested at the threshold of the other healthy groups"
            )
        return rates

    def _threshold_of_others(self, scores: Array, direction: Direction) -> Threshold:
        try:
            return self.rules.set_threshold(scores, direction)
        except NotStatedError as refusal:
            reason = f"to test a healthy group, the others set the threshold: {refusal}"
            raise NotStatedError(reason, refusal.records_needed) from None

    def _remark_excluded(self, population: Population, rate: Rate) -> None:
        aim = self.rules.false_alarm_rate
        is_limit = self.rules.threshold == "tolerance"
        if rate.low > aim or (rate.high < aim and not is_limit):
            self.notes.remarks.append(
                f"false alarms of {population.name!r}: {rate.count} of {rate.total}, {rate.value:.2%}"
                f" [{rate.low:.2%}, {rate.high:.2%}], which leaves out the {100.0 * aim:.3g} %"
                f" that it is set for"
            )

    def floor(self, false_alarms: Mapping[Population, Rate]) -> float | None:
        """False-alarm rate measured on healthy records; None if no healthy record was tested."""
        healthy = [rate for each, rate in false_alarms.items() if each.kind is Kind.HEALTHY and rate.total]
        if not healthy:
            self.notes.refusals.append(
                "no healthy record was tested, so the false-alarm rate is unknown and detections are not"
                " stated"
            )
            return None
        return sum(rate.count for rate in healthy) / sum(rate.total for rate in healthy)

    def remark_equal(self, fit: Part) -> None:
        """Add a remark if records look like one record counted several times."""
        found = fit.scores[~np.isnan(fit.scores)]
        if found.size > 1 and np.all(found == found[0]):
            self.notes.remarks.append(
                f"all {found.size} healthy fit records have the same score: rates and intervals hold for"
                " independent records, and these may be one record"
            )

    def remark_missing(self, fit: Part, faulty: Mapping[Population, Part]) -> None:
        """Add remarks on records without a score: fit records are ignored, faulty ones count as missed."""
        if fit.n_missing:
            self.notes.remarks.append(
                f"{fit.n_missing} of {fit.scores.size} healthy fit records have no score"
            )
        missing = [
            f"{own.n_missing} of {own.scores.size} at {population.name!r}"
            for population, own in faulty.items()
            if own.n_missing
        ]
        if missing:
            self.notes.remarks.append(
                f"faulty records without a score raise no alarm and count as missed: {', '.join(missing)}"
            )


def _counted(
    false_alarms: Mapping[Population, Rate], levels: Sequence[Level], rules: Rules
) -> dict[Population, int]:
    """Populations with too few records for a rate."""
    needed = rules.records_for_false_alarms
    few = {population: needed for population, rate in false_alarms.items() if rate.total < needed}
    needed = rules.records_for_detection
    return few | {
        level.population: needed
        for level in levels
        if level.detected is not None and level.detected.total < needed
    }
