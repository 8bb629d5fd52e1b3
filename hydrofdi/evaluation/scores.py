"""Scores of records, their populations and directions. NaN means that a record cannot be measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def comparable(values: ArrayLike) -> Any:
    """Round to twelve digits before a comparison, as processors differ in the last bits; same shape."""
    mantissa, exponent = np.frexp(values)
    # 40 bits of the mantissa are twelve digits.
    return np.ldexp(np.round(np.ldexp(mantissa, 40)), exponent - 40)


@dataclass(frozen=True)
class Estimate:
    """A median with an interval; ends may be infinite."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, draws: Array, confidence: float, margin: float = 0.0) -> Estimate:
        """That of equally probable values, widened by a margin."""
        tail = (1.0 - confidence) / 2.0
        # An order statistic, as infinite values cannot be interpolated.
        low, high = np.quantile(draws, tail, method="lower"), np.quantile(draws, 1.0 - tail, method="higher")
        value = np.quantile(draws, 0.5, method="nearest")
        return cls(float(value), float(low) - margin, float(high) + margin)


def measurable(scores: ArrayLike) -> tuple[Array, int]:
    """Scores that are not NaN, and the number of the others.

    Parameters
    ----------
    scores : array_like, shape (n_record,)

    Returns
    -------
    known : ndarray, shape (n_known,)
        In the order given.
    """
    values = np.asarray(scores, dtype=float)
    missing = np.isnan(values)
    return values[~missing], int(missing.sum())


def group_numbers(groups: Sequence[str]) -> NDArray[np.intp]:
    """Group of each record, from zero; a record without a group (``""``) is its own group."""
    names = [name or f"\0{record}" for record, name in enumerate(groups)]
    return np.unique(np.asarray(names), return_inverse=True)[1]


class Kind(StrEnum):
    """Purpose of a population.

    The threshold is set only on healthy fit records. ``shift`` and ``confusion`` have healthy seals but
    conditions that are not in the fit records: another operating condition, or another fault. ``alone`` are
    healthy records in which one nuisance varies; thresholds and rates do not use them. ``before``: earlier
    healthy records of the same actuators, as the reference for changes.
    """

    HEALTHY = "healthy"
    FAULT = "fault"
    SHIFT = "shift"
    CONFUSION = "confusion"
    ALONE = "alone"
    BEFORE = "before"


NOTHING = "nothing"
"""Name of the population of kind ``alone`` without nuisances; the others are named after their nuisance."""


@dataclass(frozen=True)
class Population:
    """Records drawn from the same distribution.

    Attributes
    ----------
    name : str
        Name, such as ``healthy``, ``0.1 L/min``, ``stiffer``.
    is_fit : bool
        Whether its records may be used to fit thresholds, directions and models; they are then never tested.
    severity : float
        Nominal severity of the fault [unit of the severity]; 0 without a fault.
    """

    name: str
    kind: Kind
    is_fit: bool = False
    severity: float = 0.0

    @property
    def title(self) -> str:
        """Unique title, such as ``shift stiffer``."""
        return self.name if self.name == self.kind else f"{self.kind} {self.name}"


class Direction(StrEnum):
    """Direction of change that raises an alarm; it is fixed before any test record is used."""

    RISING = "rising"
    FALLING = "falling"
    BOTH = "both"

    @property
    def n_side(self) -> int:
        """Number of limits of a threshold."""
        return 2 if self is Direction.BOTH else 1


def suspicion(scores: ArrayLike, direction: Direction, centre: float = 0.0) -> Array:
    """Transform scores so that larger values are more suspicious, as ROC curves require.

    Parameters
    ----------
    scores : array_like, shape (n_record,)
    centre : float
        Healthy reference value for both directions, such as the median of the fit records.
    """
    values = np.asarray(scores, dtype=float)
    if direction is Direction.BOTH:
        return np.abs(values - centre)
    return values if direction is Direction.RISING else -values
