"""Hits and misses by severity of a fault."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array

MOST_SEVERITIES = 1000
"""Maximum number of distinct severities; closer ones are merged."""


@dataclass(frozen=True, eq=False)
class Tally:
    """Faulty records counted by severity.

    Attributes
    ----------
    severity : ndarray, shape (n_level,)
        Ascending, distinct, positive [unit of the severity].
    hits, total : ndarray, shape (n_level,)
        Number of records detected, and number tested.
    not_measurable : int
        Number of further records without a score.
    """

    severity: Array
    hits: Array
    total: Array
    not_measurable: int = 0

    @property
    def misses(self) -> Array:
        """Number of records not detected, shape (n_level,)."""
        return self.total - self.hits

    @property
    def span(self) -> tuple[float, float]:
        """Smallest and largest tested severity."""
        return float(self.severity[0]), float(self.severity[-1])

    def pooled(self, n_level: int) -> Tally:
        """Pool adjacent severities into at most `n_level` levels of about equal size.

        A level is assigned its largest severity, at which the probability of detection is at least the mean
        of the level.
        """
        if self.severity.size <= n_level:
            return self
        middle = np.cumsum(self.total) - self.total / 2.0
        places = np.minimum((middle * n_level / self.total.sum()).astype(int), n_level - 1)
        first = np.flatnonzero(np.diff(places, prepend=-1))
        last = np.append(first[1:], places.size) - 1
        hits, total = (np.add.reduceat(counts, first).astype(float) for counts in (self.hits, self.total))
        return Tally(self.severity[last], hits, total, self.not_measurable)


def tally(severity: ArrayLike, outcomes: ArrayLike) -> Tally:
    """Count faulty records by severity.

    Parameters
    ----------
    severity : array_like, shape (n_record,)
        Positive severity; records without a fault belong to the false alarms.
    outcomes : array_like, shape (n_record,)
        1 detected, 0 not, NaN not measurable.

    Raises
    ------
    ValueError
        A severity is not a positive number.
    NotStatedError
        No record has a score.
    """
    levels, values = np.asarray(severity, dtype=float), np.asarray(outcomes, dtype=float)
    if not np.all((levels > 0.0) & np.isfinite(levels)):
        raise ValueError("severities must be positive")
    is_known = ~np.isnan(values)
    if not is_known.any():
        raise NotStatedError("no faulty record has a score")
    distinct, places = np.unique(levels[is_known], return_inverse=True)
    hits, total = (
        np.bincount(places, counts).astype(float) for counts in (values[is_known], is_known[is_known])
    )
    return Tally(distinct, hits, total, int((~is_known).sum())).pooled(MOST_SEVERITIES)
