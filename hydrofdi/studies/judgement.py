"""What is stated of a score as a detector."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hydrofdi.evaluation.auc import Area
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.pod.curve import PodCurve
from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.pod.lack_of_fit import LackOfFit
from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.studies.records import Scored, StudyRecords


@dataclass(frozen=True)
class Level:
    """Faulty test records of one nominal severity.

    Attributes
    ----------
    population : Population
    severity : float
        Mean of the true severities of its records [unit of the severity].
    detected : Rate
    area : Area or None
        Against the healthy test records; None where the scores do not give one.
    """

    population: Population
    severity: float
    detected: Rate
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
        None where the fit records do not carry one.
    false_alarms : mapping of Population to Rate
        Of the healthy test records, each shift and each confusion; empty without a threshold.
    levels : tuple of Level
        Ascending; empty without a threshold.
    curve : PodCurve or None
    lack_of_fit : LackOfFit or None
    smallest : mapping of str to DetectableSeverity
        ``q50``, ``q90`` (the estimates at 50 % and the stated probability) and ``q90_95`` (bound with the
        stated confidence).
    partial_area : float
        Up to the false-alarm rate, over all faulty test records, scaled so that 0.5 is chance; NaN without.
    refusals : tuple of str
        What could not be stated, and why.
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
    refusals: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Detection:
    """All judgements of one design of a study.

    Attributes
    ----------
    records : StudyRecords
    judgements : tuple of Judgement
        Best first: by q90/95, then by the area at the middle severity.
    pareto : frozenset of str
        Names of scores than which none needs fewer channels and finds smaller faults at a kept false-alarm
        rate.
    remarks : tuple of str
        Sentences that belong to all numbers, such as that the draws are not independent.
    """

    records: StudyRecords
    judgements: tuple[Judgement, ...]
    pareto: frozenset[str] = frozenset()
    remarks: tuple[str, ...] = ()
