"""Who is who among records that are judged: populations of healthy and faulty records."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Kind(StrEnum):
    """What a population is for.

    The threshold is set on healthy fit records alone. ``shift`` and ``confusion`` are healthy seals whose
    plant the threshold never saw: another operating condition, or another fault. ``alone`` and ``sobol`` are
    healthy records that show which nuisance moves a score: one nuisance varies, or the matrices of a Sobol
    design; thresholds and rates leave them out. ``before``: healthy records of the actuators of all these,
    taken before, that changes are taken against.
    """

    HEALTHY = "healthy"
    FAULT = "fault"
    SHIFT = "shift"
    CONFUSION = "confusion"
    ALONE = "alone"
    SOBOL = "sobol"
    BEFORE = "before"


FIRST, SECOND, AGAIN = "A", "B", "A again"
"""Names of populations of a Sobol design: the rows of its two matrices, and the actuators of the first
recorded again. Those of A with one column from B have the name of that parameter."""

NOTHING = "nothing"
"""Name of the population of kind ``alone`` in which no nuisance varies; the others have that of theirs."""


@dataclass(frozen=True)
class Population:
    """Records that are drawn alike.

    Attributes
    ----------
    name : str
        Such as ``healthy``, ``0.1 L/min``, ``stiffer``.
    kind : Kind
    is_fit : bool
        Whether thresholds, directions and models may be fitted to its records, which are then never tested.
    severity : float
        Nominal severity of the fault [unit of the severity]; 0 without one.
    """

    name: str
    kind: Kind
    is_fit: bool = False
    severity: float = 0.0

    @property
    def title(self) -> str:
        """What it is called among all populations, such as ``shift stiffer``."""
        return self.name if self.name == self.kind else f"{self.kind} {self.name}"
