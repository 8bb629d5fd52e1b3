"""Who is who among records that are judged: populations of healthy and faulty records."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Kind(StrEnum):
    """What a population is for.

    The threshold is set on healthy fit records alone. ``shift`` and ``confusion`` are healthy seals whose
    plant the threshold never saw: another operating condition, or another fault.
    """

    HEALTHY = "healthy"
    FAULT = "fault"
    SHIFT = "shift"
    CONFUSION = "confusion"


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
