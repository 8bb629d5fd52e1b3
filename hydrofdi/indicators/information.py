"""Fisher information of records about the unknowns of an estimator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from hydrofdi.records import Array, RecordBatch


@dataclass(frozen=True)
class Unknown:
    """An unknown of an estimator.

    Attributes
    ----------
    name : str
        Name in messages and tables.
    unit : str
        SI; ``"1"`` for relative quantities.
    deviation : float
        Prior standard deviation.
    """

    name: str
    unit: str
    deviation: float


@dataclass(frozen=True, eq=False)
class Information:
    """Information of one record about the unknowns of an estimator.

    Attributes
    ----------
    unknowns : tuple of Unknown, length n
    gramian : ndarray, shape (n, n)
        Information of the record, scaled by the prior standard deviations.
    covariance : ndarray, shape (n, n)
        Posterior covariance of the unknowns at the end of the record, in the same scaling.
    n_motion : int
        Number of leading unknowns that are states of the motion; the others are parameters.
    """

    unknowns: tuple[Unknown, ...]
    gramian: Array
    covariance: Array
    n_motion: int = 0


@runtime_checkable
class Informative(Protocol):
    """An indicator that can compute the information of a record."""

    def information(self, records: RecordBatch) -> Information:
        """Information of the first record."""
        ...
