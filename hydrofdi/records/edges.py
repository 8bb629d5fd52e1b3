"""Edges of a channel that drives cycles."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array

BAND = 0.2
"""Width of the band around the middle as a share of the range: noise does not cause an edge."""
Direction = Literal["rising", "falling", "both"]
_WANTED = {"rising": (1,), "falling": (-1,), "both": (1, -1)}


def drive_edges(
    samples: Array, drive: tuple[float, float], direction: Direction, side: int = 0
) -> tuple[NDArray[np.intp], int]:
    """First sample beyond the band around the middle after each change of side, and the last side.

    Parameters
    ----------
    samples : ndarray, shape (n_time,)
    drive : (float, float)
        Lowest and highest value of the channel.
    direction : str
        ``rising``, ``falling`` or ``both``.
    side : int
        Side of the preceding samples: 1 above the band, −1 below it, 0 if unknown.
    """
    low, high = drive
    middle, half = (low + high) / 2.0, BAND * (high - low) / 2.0
    sides = np.concatenate([[side], 1 * (samples > middle + half) - (samples < middle - half)])
    decided = np.flatnonzero(sides)
    if not decided.size:
        return decided, side
    changes = decided[1:][np.diff(sides[decided]) != 0]
    return changes[np.isin(sides[changes], _WANTED[direction])] - 1, int(sides[decided[-1]])
