"""Sensitivity of a score to each nuisance of a study."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from hydrofdi.evaluation.populations import NOTHING, Kind, Population
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.sensitivity import Reach, Response, Spread, relative_spread
from hydrofdi.studies.parts import Notes
from hydrofdi.studies.records import Scored, StudyRecords


@dataclass(frozen=True)
class Nuisance:
    """Effect of one nuisance alone on a healthy score; None if there is no result.

    Attributes
    ----------
    parameter : str
        Dotted name; ``nothing`` for the variation between records of one actuator.
    alone : Spread or None
        Inner 90 % range of the score if only this nuisance varies, relative to the range if all vary.
    reach : Reach or None
        Faults that the nuisance imitates and hides.
    """

    parameter: str
    alone: Spread | None
    reach: Reach | None


@dataclass(frozen=True)
class Nuisances:
    """All nuisances of a score, the variation between records last; what all together imitate and hide."""

    each: tuple[Nuisance, ...]
    together: Reach | None
    refusals: tuple[str, ...]


def nuisances_of(records: StudyRecords, scored: Scored, *, confidence: float = 0.95) -> Nuisances | None:
    """Sensitivity of a score to the nuisances; None if the study has no records for it.

    Parameters
    ----------
    records : StudyRecords
    scored : Scored
    confidence : float
        Confidence level of all intervals.
    """
    notes = Notes()
    alone = sorted(records.chosen(Kind.ALONE, is_fit=False), key=lambda each: each.name == NOTHING)
    own = {each.name: _scores(records, scored, each) for each in alone}
    if not own:
        return None
    of_kind = [each for each in records.populations if each.kind is Kind.HEALTHY]
    healthy = _scores(records, scored, *of_kind)
    faults = sorted(
        (_severity(records, each), place, _scores(records, scored, each))
        for place, each in enumerate(records.chosen(Kind.FAULT, is_fit=False))
    )
    response = None
    if faults:
        severity, _, scores = zip(*faults, strict=True)
        response = notes.unless_refused(lambda: Response(healthy, scores, severity, confidence=confidence))

    def reach(scores: Array, centre: Array) -> Reach | None:
        return notes.unless_refused(lambda: response.reach(scores, centre)) if response else None

    each = tuple(
        Nuisance(
            name,
            notes.unless_refused(partial(relative_spread, scores, healthy, confidence=confidence)),
            reach(scores, own[NOTHING]),
        )
        for name, scores in own.items()
    )
    return Nuisances(each, reach(healthy, healthy), tuple(dict.fromkeys(notes.refusals)))


def _scores(records: StudyRecords, scored: Scored, *populations: Population) -> Array:
    rows = [records.rows(population) for population in populations]
    return scored.values[np.concatenate(rows)] if rows else np.empty(0)


def _severity(records: StudyRecords, population: Population) -> float:
    """Mean of the true severities; the nominal one if they are unknown."""
    known = records.severity[records.rows(population)]
    known = known[np.isfinite(known)]
    return float(known.mean()) if known.size else population.severity
