"""What a record tells an estimator about its unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from hydrofdi.records import Array, RecordBatch

NAMES_AND_UNITS = {
    "pressure_1": ("P1", "Pa"),
    "pressure_2": ("P2", "Pa"),
    "position": ("position", "m"),
    "velocity": ("velocity", "m/s"),
    "resistance": ("friction and load", "N"),
    "leakage": ("leakage", "m^3/s"),
    "bulk_modulus": ("bulk modulus", "1"),
    "supply": ("supply pressure", "1"),
    "flow_gain": ("flow gain", "1"),
    "offset": ("valve null", "m"),
    "lap": ("lap", "m"),
    "clearance": ("clearance", "m^3/(s*Pa)"),
    "bias_1": ("bias of P1", "Pa"),
    "bias_2": ("bias of P2", "Pa"),
}
"""Unknown → its name in messages and tables, and its SI unit, ``"1"`` for relative quantities."""


@dataclass(frozen=True)
class Unknown:
    """Standard deviations of an unknown before and after a record, in its SI unit, ``1`` for shares."""

    name: str
    unit: str
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class Information:
    """Information of one record about the unknowns of an estimator.

    Attributes
    ----------
    unknowns : tuple of Unknown, length n
    covariance : ndarray, shape (n, n)
        Posterior covariance of the unknowns at the end of the record, in units of the prior deviations.
    n_motion : int
        Number of leading unknowns that are states of the motion; the others are parameters.
    """

    unknowns: tuple[Unknown, ...]
    covariance: Array
    n_motion: int = 0

    @classmethod
    def of(
        cls, names: Sequence[str], deviations: Sequence[float], covariance: Array, n_motion: int = 0
    ) -> Information:
        """Information of unknowns with prior deviations [SI] and a relative posterior covariance."""
        shares = np.sqrt(np.diag(covariance)).tolist()
        unknowns = (
            Unknown(*NAMES_AND_UNITS[name], float(deviation), float(deviation * share))
            for name, deviation, share in zip(names, deviations, shares, strict=True)
        )
        return cls(tuple(unknowns), covariance, n_motion)


@runtime_checkable
class Informative(Protocol):
    """An indicator that can compute the information of a record."""

    def information(self, records: RecordBatch) -> Information:
        """Information of the first record."""
        ...
