"""Smallest and largest of some numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """Smallest and largest of some numbers; NaN if there is none."""

    low: float
    high: float


def range_of(values: Iterable[float]) -> Range:
    """The range of the finite numbers."""
    known = [value for value in values if not math.isnan(value)]
    return Range(min(known, default=math.nan), max(known, default=math.nan))
