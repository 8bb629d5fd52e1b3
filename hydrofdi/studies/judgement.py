"""Results of the evaluation of a score as a detector."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from hydrofdi.evaluation.auc import Area
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.pod.lack_of_fit import LackOfFit
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.studies.records import Scored, StudyRecords
from hydrofdi.studies.rules import Rules


@dataclass(frozen=True)
class Level:
    """Faulty test records of one nominal severity.

    Attributes
    ----------
    population : Population
    severity : float
        Mean true severity of its records [unit of the severity]; NaN if unknown.
    detected : Rate or None
        Detection rate; None without a threshold or a measured false-alarm rate.
    area : Area or None
        Area under the ROC curve against the healthy test records; None if undefined.
    """

    population: Population
    severity: float
    detected: Rate | None
    area: Area | None


@dataclass(frozen=True)
class Judgement:
    """Evaluation of a score as a detector, at the threshold set by healthy fit records.

    Attributes
    ----------
    scored : Scored
    direction : Direction
        Direction, declared or learned from fit records.
    threshold : Threshold or None
        None if the fit records do not carry one.
    false_alarms : mapping of Population to Rate
        False-alarm rates of healthy test records, each shift and each confusion; empty without a threshold.
    levels : tuple of Level
        Ascending.
    curve : PodCurve or None
    lack_of_fit : LackOfFit or None
    smallest : mapping of str to DetectableSeverity
        ``q50``, ``q90`` (estimates at 50 % and at the required probability), ``q90_95`` (bound with the
        required confidence) and, for scores selected among many, ``q90_95_of_all`` (simultaneous bound);
        refused values are absent.
    partial_area : float
        Partial area up to the false-alarm rate over all faulty test records, scaled so that 0.5 is chance;
        NaN if undefined.
    counted : mapping of Population to int
        Population with too few records for a rate (only its alarms are counted) → number of records that a
        rate needs.
    refusals : tuple of str
        Results that are refused, and why.
    remarks : tuple of str
        Remarks on the results.
    bounding : tuple of PodCurve
        Curves for the bounds, the most likely first; all are compared with its likelihood.
    """

    scored: Scored
    direction: Direction
    threshold: Threshold | None
    false_alarms: Mapping[Population, Rate]
    levels: tuple[Level, ...]
    curve: PodCurve | None
    lack_of_fit: LackOfFit | None
    smallest: Mapping[str, DetectableSeverity]
    partial_area: float
    counted: Mapping[Population, int] = field(default_factory=dict)
    refusals: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    bounding: tuple[PodCurve, ...] = ()

    @property
    def keeps_its_rate(self) -> bool | None:
        """Whether healthy test records and shifts are compatible with the false-alarm rate of the threshold.

        They are if no lower limit of their rates exceeds the upper limit from the fit records. None if
        unknown: without a threshold or healthy test records, or if any of these populations has too few
        records for a rate. Confusions are not included: they have another fault, so their alarms are
        justified.
        """
        if self.threshold is None:
            return None
        tested = {each for each in self.false_alarms if each.kind is not Kind.CONFUSION}
        if tested & set(self.exceeded):
            return False
        is_known = any(each.kind is Kind.HEALTHY for each in tested) and not tested & self.counted.keys()
        return True if is_known else None

    @property
    def exceeded(self) -> tuple[Population, ...]:
        """Populations without the fault in which more alarm than the threshold allows."""
        if self.threshold is None:
            return ()
        allowed = self.threshold.interval[1]
        return tuple(each for each, rate in self.false_alarms.items() if rate.low > allowed)

    @property
    def middle_area(self) -> float:
        """Area under the ROC curve at the middle level; NaN if undefined."""
        areas = [level.area.value for level in self.levels if level.area is not None]
        return areas[(len(areas) - 1) // 2] if areas else math.nan


@dataclass(frozen=True, eq=False)
class Detection:
    """Evaluation of all scores of one design of a study.

    Attributes
    ----------
    records : StudyRecords
    judgements : tuple of Judgement
        Best first, as from `ranked`.
    rules : Rules
        Rules of the evaluation.
    pareto : frozenset of str
        Names of Pareto-optimal scores: no other score needs fewer channels and detects smaller faults at its
        false-alarm rate.
    remarks : tuple of str
        Remarks on all results, such as that the draws are not independent.
    """

    records: StudyRecords
    judgements: tuple[Judgement, ...]
    rules: Rules
    pareto: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
