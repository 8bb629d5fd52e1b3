"""Events in a channel that divide it into cycles."""

from __future__ import annotations

from typing import Literal

import numpy as np

from hydrofdi.records.batch import Array

_BAND = 0.2
"""Width of the band around the middle, and size of a turn, as a share of the range: noise is no event."""


def edges(samples: Array, direction: Literal["rising", "falling", "both"]) -> list[int]:
    """First samples beyond the middle of the range, after the other side of a band around it was left.

    Parameters
    ----------
    samples : ndarray, shape (n_time,)
    direction : str
        ``rising``, ``falling`` or ``both``.
    """
    low, high = _range(samples)
    if not high > low:
        return []
    middle, half = (low + high) / 2.0, _BAND * (high - low) / 2.0
    side = np.where(samples > middle + half, 1, np.where(samples < middle - half, -1, 0))
    decided = np.flatnonzero(side)
    changes = decided[1:][np.diff(side[decided]) != 0]
    wanted = {"rising": [1], "falling": [-1], "both": [1, -1]}[direction]
    return [int(change) for change in changes if side[change] in wanted]


def reversals(position: Array) -> list[int]:
    """Samples at which a position turns; turns smaller than a fifth of its range are none.

    Parameters
    ----------
    position : ndarray, shape (n_time,)
    """
    low, high = _range(position)
    size = _BAND * (high - low)
    if not size > 0.0:
        return []
    turns: list[int] = []
    heading, extreme = 0, 0
    for n, value in enumerate(position.tolist()):
        away = value - position[extreme]
        if heading == 0 and abs(away) >= size:
            heading, extreme = (1 if away > 0.0 else -1), n
        elif heading and heading * away > 0.0:
            extreme = n
        elif heading and -heading * away >= size:
            turns.append(extreme)
            heading, extreme = -heading, n
    return turns


def _range(samples: Array) -> tuple[float, float]:
    finite = samples[np.isfinite(samples)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
