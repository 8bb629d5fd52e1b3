"""What is stated of a score as a detector."""

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
        Mean of the true severities of its records [unit of the severity]; NaN if they are not known.
    detected : Rate or None
        None without a threshold.
    area : Area or None
        Against the healthy test records; None if the scores do not give one.
    """

    population: Population
    severity: float
    detected: Rate | None
    area: Area | None


@dataclass(frozen=True)
class Judgement:
    """A score as a detector, at the threshold that healthy fit records set.

    Attributes
    ----------
    scored : Scored
    direction : Direction
        As defined, or as fit records showed it.
    threshold : Threshold or None
        None if the fit records do not carry one.
    false_alarms : mapping of Population to Rate
        Of the healthy test records, each shift and each confusion; empty without a threshold.
    levels : tuple of Level
        Ascending.
    curve : PodCurve or None
    lack_of_fit : LackOfFit or None
    smallest : mapping of str to DetectableSeverity
        ``q50``, ``q90`` (the estimates at 50 % and the stated probability), ``q90_95`` (bound with the
        stated confidence) and, of scores chosen among many, ``q90_95_of_all`` (with the confidence at which
        the bounds of all hold together); without those that are not stated.
    partial_area : float
        Up to the false-alarm rate, over all faulty test records, scaled so that 0.5 is chance; NaN without.
    counted : mapping of Population to int
        Populations with too few records for a rate: their alarms are counted, and no rate is stated → the
        number of records that one needs.
    refusals : tuple of str
        What could not be stated, and why.
    remarks : tuple of str
        What has to be known of what is stated.
    bounding : tuple of PodCurve
        The curves that bounds are taken from, the likeliest first; all are held against its likelihood.
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
        """Whether healthy test records and shifts are compatible with the threshold's own false-alarm rate.

        They are where no lower limit of their rates lies above the upper limit that the fit records allow.
        None if that is not known: without a threshold or healthy test records, and where any of these
        populations has too few records for a rate. Confusions do not count: what alarms there is a fault, if
        another one.
        """
        if self.threshold is None:
            return None
        tested = {each: rate for each, rate in self.false_alarms.items() if each.kind is not Kind.CONFUSION}
        if any(rate.low > self.threshold.interval[1] for rate in tested.values()):
            return False
        is_known = any(each.kind is Kind.HEALTHY for each in tested) and not tested.keys() & self.counted
        return True if is_known else None

    @property
    def middle_area(self) -> float:
        """Area under the ROC curve at the middle level; NaN without."""
        areas = [level.area.value for level in self.levels if level.area is not None]
        return areas[(len(areas) - 1) // 2] if areas else math.nan


@dataclass(frozen=True, eq=False)
class Detection:
    """All judgements of one design of a study.

    Attributes
    ----------
    records : StudyRecords
    judgements : tuple of Judgement
        Best first, as `ranked`.
    rules : Rules
        By which they are judged.
    pareto : frozenset of str
        Names of scores than which none needs fewer channels and finds smaller faults at a kept false-alarm
        rate.
    remarks : tuple of str
        Sentences that belong to all numbers, such as that the draws are not independent.
    """

    records: StudyRecords
    judgements: tuple[Judgement, ...]
    rules: Rules
    pareto: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
