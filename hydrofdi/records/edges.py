"""Edges of a channel that drives cycles, and its period."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array, RecordBatch
from hydrofdi.records.channels import Channel

BAND = 0.2
"""Width of the band around the middle as a share of the range: noise does not cause an edge."""
_LEAST_STEPS, _UNEVEN, _ALIKE = 3, 0.05, 0.8
"""Of a period: least distances between edges, their largest spread, and least correlation one period on."""
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


def found_period(batch: RecordBatch, row: int = 0) -> float | None:
    """Period of the drive of a record [s]: the one that is known, or that of u; None if it has none.

    The rising edges of u are even, and u repeats from one to the next. It is rounded to half a sample.
    """
    u = batch.channels.get(Channel.INPUT_VOLTAGE)
    if batch.drive_period is not None or u is None or not np.isfinite(samples := u[row]).all():
        return batch.drive_period
    steps = np.diff(drive_edges(samples, (float(samples.min()), float(samples.max())), "rising")[0])
    if steps.size < _LEAST_STEPS or np.ptp(steps) > max(2.0, _UNEVEN * steps.mean()):
        return None
    lag = round(float(steps.mean()))
    is_repeated = np.corrcoef(samples[:-lag], samples[lag:])[0, 1] > _ALIKE
    return round(2.0 * float(steps.mean())) / (2.0 * batch.sampling_frequency) if is_repeated else None
