"""Information of records about the unknowns of an estimator, in addition to the prior."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from hydrofdi.records import Array, RecordBatch


@dataclass(frozen=True)
class Unknown:
    """What an estimator does not know.

    Attributes
    ----------
    name : str
        In words.
    unit : str
        SI; ``"1"`` for shares.
    deviation : float
        Standard deviation beforehand.
    """

    name: str
    unit: str
    deviation: float


@dataclass(frozen=True, eq=False)
class Information:
    """What a record tells an estimator.

    Attributes
    ----------
    unknowns : tuple of Unknown, length n
    gramian : ndarray, shape (n, n)
        Information of the record, in units of the deviations beforehand.
    covariance : ndarray, shape (n, n)
        Of the unknowns behind the record, with what was known beforehand, in the same units.
    n_motion : int
        How many of the first unknowns are states of the motion; the others are parameters.
    """

    unknowns: tuple[Unknown, ...]
    gramian: Array
    covariance: Array
    n_motion: int = 0


@runtime_checkable
class Informative(Protocol):
    """An indicator that can say what a record will tell it."""

    def information(self, records: RecordBatch) -> Information:
        """What the first record tells."""
        ...
