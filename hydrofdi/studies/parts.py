"""Scores of some populations of a study, and results from tested levels without a curve."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.pod import DetectableSeverity, PodCurve, Tally, last_shown
from hydrofdi.evaluation.rates import Rate, alarm_rate, confidence_text
from hydrofdi.evaluation.scores import NOTHING, Array, Kind, Population, comparable
from hydrofdi.evaluation.sensitivity import EquivalentFault, Response, Spread, relative_spread
from hydrofdi.evaluation.threshold import Threshold, records_needed
from hydrofdi.studies.records import Scored, StudyRecords

Stated = TypeVar("Stated")


@dataclass(frozen=True, eq=False)
class Part:
    """Scores of some records, in a reproducible order that does not depend on that of the records."""

    scores: Array
    severity: Array
    groups: list[str] | None

    @property
    def n_missing(self) -> int:
        """Number of records without a score."""
        return int(np.isnan(self.scores).sum())

    def rate(self, threshold: Threshold, confidence: float) -> Rate:
        """Alarm rate."""
        return alarm_rate(threshold.outcomes(self.scores), groups=self.groups, confidence=confidence)

    def detections(self, threshold: Threshold) -> Array:
        """1 if detected, 0 if not, shape (n_record,); a record without a score raises no alarm."""
        return np.nan_to_num(threshold.outcomes(self.scores), nan=0.0)

    def detected(self, threshold: Threshold, confidence: float) -> Rate:
        """Detection rate of faulty records; those without a score count as missed."""
        rate = alarm_rate(self.detections(threshold), groups=self.groups, confidence=confidence)
        return replace(rate, not_measurable=self.n_missing)


def part(records: StudyRecords, scored: Scored, populations: Collection[Population]) -> Part:
    """Scores of all records of some populations."""
    numbers = [records.populations.index(population) for population in populations]
    rows = np.flatnonzero(np.isin(records.of_record, numbers))
    rows = rows[np.lexsort((records.severity[rows], scored.values[rows]))]
    groups = None if records.groups is None else [records.groups[row] for row in rows.tolist()]
    return Part(scored.values[rows], records.severity[rows], groups)


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
    def tally(self) -> Tally:
        """Hits of each level at its *largest* true severity.

        The probability of detection there is at least the mean of the level, so detectable severities are not
        too small.
        """
        rates = [level.detected(self.threshold, 0.95) for level in self.levels]
        hits, total = (
            np.array([getattr(rate, name) for rate in rates], float) for name in ("count", "total")
        )
        largest = [level.severity.max() for level in self.levels]
        return Tally(np.maximum.accumulate(largest), hits, total)

    def lie_on_the_rise(self, curve: PodCurve) -> bool:
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

    def with_one_miss_more(self) -> Array | None:
        """Outcomes with one miss added in the smallest level that is always detected.

        The miss is at the largest severity of the level. None if no level is always detected.
        """
        outcomes, first = self.outcomes.copy(), 0
        for level, hits, total in zip(self.levels, self.tally.hits, self.tally.total, strict=True):
            if hits == total:
                outcomes[first + int(np.argmax(level.severity))] = 0.0
                return outcomes
            first += level.severity.size
        return None

    def bound(self, probability: float, confidence: float) -> DetectableSeverity:
        """Last level whose one-sided limit of the detection rate meets a probability."""
        rates = [level.detected(self.threshold, 2.0 * confidence - 1.0) for level in self.levels]
        shown = np.array([comparable(rate.low) >= comparable(probability) for rate in rates])
        n_group, needed = rates[-1].n_group, records_needed(1.0 - probability, confidence)
        if n_group is not None and n_group < needed and not shown[-1]:
            raise NotStatedError(
                f"{quantile_name(probability, confidence)} needs {needed} groups of faulty records that"
                f" agree; there are {n_group}",
                needed,
            )
        return last_shown(self.tally.severity, shown, probability, confidence)


@dataclass
class Notes:
    """Remarks and refusals collected during an evaluation."""

    refusals: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def unless_refused(self, state: Callable[[], Stated]) -> Stated | None:
        """Result of `state`, or None if it is refused; the refusal is noted."""
        try:
            return state()
        except NotStatedError as refusal:
            self.refusals.append(str(refusal))
            return None


def quantile_name(probability: float, confidence: float) -> str:
    """Name such as ``q90/95``: detected with 90 % probability at 95 % confidence."""
    return f"q{100.0 * probability:.5g}/{confidence_text(confidence)}"


@dataclass(frozen=True)
class Nuisance:
    """Effect of one nuisance alone on a healthy score; None if there is no result.

    Attributes
    ----------
    parameter : str
        Dotted name; ``nothing`` for the variation between records of one actuator.
    alone : Spread or None
        Inner 90 % range of the score if only this nuisance varies, relative to the range if all vary.
    imitated : EquivalentFault or None
        As from `Response.imitated`.
    """

    parameter: str
    alone: Spread | None
    imitated: EquivalentFault | None


def nuisances_of(
    records: StudyRecords, scored: Scored, *, confidence: float = 0.95
) -> tuple[list[Nuisance], list[str]]:
    """Sensitivity of a score to each nuisance, the variation between records last, and what is refused."""
    notes = Notes()
    alone = sorted(records.chosen(Kind.ALONE, is_fit=False), key=lambda each: each.name == NOTHING)
    own = {each.name: records.values(scored, [each]) for each in alone}
    if not own:
        return [], []
    of_kind = [each for each in records.populations if each.kind is Kind.HEALTHY]
    healthy = records.values(scored, of_kind)
    faults = sorted(
        (_severity(records, each), index, records.values(scored, [each]))
        for index, each in enumerate(records.chosen(Kind.FAULT, is_fit=False))
    )
    response = None
    if faults:
        severity, _, scores = zip(*faults, strict=True)
        response = notes.unless_refused(lambda: Response(healthy, scores, severity, confidence=confidence))
    found = []
    for name, values in own.items():
        spread = notes.unless_refused(partial(relative_spread, values, healthy, confidence=confidence))
        imitated = None
        if response is not None:
            imitated = notes.unless_refused(partial(response.imitated, values, own[NOTHING]))
        found.append(Nuisance(name, spread, imitated))
    return found, [*dict.fromkeys(notes.refusals)]


def _severity(records: StudyRecords, population: Population) -> float:
    """Mean of the true severities; the nominal one if they are unknown."""
    known = records.severity[records.rows(population)]
    known = known[np.isfinite(known)]
    return float(known.mean()) if known.size else population.severity
