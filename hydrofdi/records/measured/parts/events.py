"""Events in a channel that divide it into cycles."""

from __future__ import annotations

import numpy as np

from hydrofdi.records.batch import Array
from hydrofdi.records.edges import BAND, Direction, drive_edges


def edges(samples: Array, direction: Direction) -> list[int]:
    """First sample beyond a band around the middle of the range, after each change of side.

    Parameters
    ----------
    samples : ndarray, shape (n_time,)
    direction : str
        ``rising``, ``falling`` or ``both``.
    """
    drive = _range(samples)
    return drive_edges(samples, drive, direction)[0].tolist() if drive[1] > drive[0] else []


def reversals(position: Array) -> list[int]:
    """Samples at which a position reverses; reversals below a fifth of its range do not count.

    Parameters
    ----------
    position : ndarray, shape (n_time,)
    """
    low, high = _range(position)
    size = BAND * (high - low)
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
