"""Populations of healthy and faulty records."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


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
    kind : Kind
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
