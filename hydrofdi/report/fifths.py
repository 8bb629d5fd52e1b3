"""Many values in a few groups."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_VALUES = 12
"""Most different values that are shown one by one; more are divided into fifths."""

_FIFTHS = 5


@dataclass(frozen=True)
class Fifth:
    """A fifth of some values: its ends, and which values belong to it, shape (n,)."""

    low: float
    high: float
    members: NDArray[np.bool_]


def fifths(values: NDArray[np.float64]) -> list[Fifth]:
    """Values by size, in fifths of equal number."""
    edges = np.quantile(values, np.linspace(0.0, 1.0, _FIFTHS + 1))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, _FIFTHS - 1)
    return [Fifth(float(edges[k]), float(edges[k + 1]), place == k) for k in range(_FIFTHS)]
