"""Sensitivity of a score to each nuisance of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.populations import AGAIN, FIRST, NOTHING, SECOND, Kind, Population
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.sensitivity.estimate import Estimate
from hydrofdi.evaluation.sensitivity.indices import SobolIndices, sobol_indices
from hydrofdi.evaluation.sensitivity.response import Reach, Response
from hydrofdi.evaluation.sensitivity.spread import relative_spread
from hydrofdi.studies.parts import Notes
from hydrofdi.studies.records import Scored, StudyRecords

MATRICES = (FIRST, SECOND, AGAIN)


@dataclass(frozen=True)
class Nuisance:
    """Effect of one nuisance on a healthy score; None if there is no result.

    Attributes
    ----------
    parameter : str
        Dotted name; ``nothing`` for the variation between records of one actuator.
    alone : Estimate or None
        Inner 90 % range of the score if only this nuisance varies, relative to the range if all vary.
    reach : Reach or None
        Faults that the nuisance imitates and hides.
    first_order, total : Estimate or None
        Sobol indices. The variation between records has only a total index.
    """

    parameter: str
    alone: Estimate | None = None
    reach: Reach | None = None
    first_order: Estimate | None = None
    total: Estimate | None = None


@dataclass(frozen=True)
class Nuisances:
    """All nuisances of a score, in the order of the study.

    Attributes
    ----------
    each : tuple of Nuisance
        Nuisances; the variation between records comes last.
    together : Reach or None
        Faults that all nuisances together imitate and hide.
    n_lost : int
        Number of base points of the Sobol design excluded because a score is missing.
    refusals : tuple of str
        Results that are refused, and why.
    """

    each: tuple[Nuisance, ...]
    together: Reach | None
    n_lost: int
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
    found = _Scores(records, scored.values, confidence)
    if not found.names(Kind.ALONE) and not found.names(Kind.SOBOL):
        return None
    indices, response = found.indices(), found.response()
    shares = _shares(found.names(Kind.SOBOL, *MATRICES), indices)
    names = dict.fromkeys([*shares, *found.names(Kind.ALONE, NOTHING), NOTHING])
    each = tuple(
        Nuisance(name, found.alone(name), found.reach(response, name), *shares.get(name, (None, None)))
        for name in names
    )
    n_lost = indices.n_lost if indices else 0
    return Nuisances(each, found.reach_together(response), n_lost, tuple(dict.fromkeys(found.notes.refusals)))


def _shares(
    names: Sequence[str], indices: SobolIndices | None
) -> dict[str, tuple[Estimate | None, Estimate | None]]:
    """First-order and total index of each nuisance, and the fraction from variation between records."""
    if indices is None:
        return {}
    of_each = dict(zip(names, zip(indices.first_order, indices.total, strict=True), strict=True))
    return {**of_each, NOTHING: (None, indices.noise)}


class _Scores:
    """Scores of the populations of a study."""

    def __init__(self, records: StudyRecords, values: Array, confidence: float) -> None:
        self._records, self._values, self._confidence = records, values, confidence
        self._healthy = self._of(*(each for each in records.populations if each.kind is Kind.HEALTHY))
        self._own = {(each.kind, each.name): each for each in records.populations}
        self.notes = Notes()

    def names(self, kind: Kind, *others: str) -> list[str]:
        """Names of the populations of a kind, with exceptions."""
        return [name for own, name in self._own if own is kind and name not in others]

    def alone(self, name: str) -> Estimate | None:
        """Relative spread with one nuisance."""
        population = self._own.get((Kind.ALONE, name))
        if population is None:
            return None
        scores = self._of(population)
        return self.notes.unless_refused(
            lambda: relative_spread(scores, self._healthy, confidence=self._confidence)
        )

    def indices(self) -> SobolIndices | None:
        """Sobol indices, in the order of the names."""
        names = self.names(Kind.SOBOL, *MATRICES)
        if not names:
            return None
        first, second, again = (self._of(self._own[Kind.SOBOL, name]) for name in MATRICES)
        pages = [self._of(self._own[Kind.SOBOL, name]) for name in names]
        return self.notes.unless_refused(
            lambda: sobol_indices(first, second, pages, again, confidence=self._confidence)
        )

    def response(self) -> Response | None:
        """Medians of the score over the tested faults; None without faults."""
        faults = sorted(self._records.chosen(Kind.FAULT, is_fit=False), key=self._severity)
        if not faults or not self.names(Kind.ALONE):
            return None
        severity, scores = [self._severity(each) for each in faults], [self._of(each) for each in faults]
        return self.notes.unless_refused(
            lambda: Response(self._healthy, scores, severity, confidence=self._confidence)
        )

    def reach(self, response: Response | None, name: str) -> Reach | None:
        """Faults that one nuisance imitates and hides."""
        population, plain = self._own.get((Kind.ALONE, name)), self._own.get((Kind.ALONE, NOTHING))
        if response is None or population is None or plain is None:
            return None
        return self.notes.unless_refused(lambda: response.reach(self._of(population), self._of(plain)))

    def reach_together(self, response: Response | None) -> Reach | None:
        """Faults that all nuisances together imitate and hide."""
        if response is None:
            return None
        return self.notes.unless_refused(lambda: response.reach(self._healthy, self._healthy))

    def _of(self, *populations: Population) -> Array:
        rows = [self._records.rows(population) for population in populations]
        return self._values[np.concatenate(rows)] if rows else np.empty(0)

    def _severity(self, population: Population) -> float:
        """Mean of the true severities; the nominal one if they are unknown."""
        known = self._records.severity[self._records.rows(population)]
        known = known[np.isfinite(known)]
        return float(known.mean()) if known.size else population.severity
