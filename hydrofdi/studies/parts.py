"""The scores of some populations of a study."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.studies.records import Scored, StudyRecords

Stated = TypeVar("Stated")


@dataclass(frozen=True, eq=False)
class Part:
    """Scores of some records, in an order that does not depend on that of the records.

    Attributes
    ----------
    scores, severity : ndarray, shape (n_record,)
    groups : list of str or None
    """

    scores: Array
    severity: Array
    groups: list[str] | None

    def rate(self, threshold: Threshold, confidence: float) -> Rate:
        """The rate of alarms."""
        return alarm_rate(threshold.outcomes(self.scores), groups=self.groups, confidence=confidence)


def part(records: StudyRecords, scored: Scored, populations: Collection[Population]) -> Part:
    """The scores of all records of some populations."""
    numbers = [records.populations.index(population) for population in populations]
    rows = np.flatnonzero(np.isin(records.of_record, numbers))
    rows = rows[np.lexsort((records.severity[rows], scored.values[rows]))]
    groups = None if records.groups is None else [records.groups[row] for row in rows.tolist()]
    return Part(scored.values[rows], records.severity[rows], groups)


def records_without_number(records: StudyRecords, scored: Scored) -> dict[str, int]:
    """Name of a population → how many of its records have no score; without those that have all."""
    missing = {
        each.name: int(np.isnan(scored.values[records.rows(each)]).sum()) for each in records.populations
    }
    return {name: count for name, count in missing.items() if count}


@dataclass
class Notes:
    """Sentences that come up while a score is judged.

    Attributes
    ----------
    refusals : list of str
        What is not stated, and why.
    remarks : list of str
        What has to be known of what is stated.
    """

    refusals: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def unless_refused(self, state: Callable[[], Stated]) -> Stated | None:
        """What can be stated; None, with the refusal noted, where it cannot."""
        try:
            return state()
        except NotStatedError as refusal:
            self.refusals.append(str(refusal))
            return None
