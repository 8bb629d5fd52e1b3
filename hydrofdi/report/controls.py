"""The two controls that the paper lacks: the rule on a sealed actuator, and the matched baseline."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.claims import D3
from hydrofdi.report.modes import ABSENT, ModeGrid
from hydrofdi.report.table import Levels, largest_positive


@dataclass(frozen=True)
class SealedAlarm:
    """What the d3 rule says of an actuator without any leak, at an EBM above normal.

    Attributes
    ----------
    reading : int
    bulk_modulus : float
        β [Pa].
    delta_fixed : tuple of float
        δ of all levels against the fixed normal [%].
    alarm : bool or None
        Whether δd3 is positive and the largest; None where the run is missing or failed.
    """

    reading: int
    bulk_modulus: float
    delta_fixed: Levels
    alarm: bool | None


@dataclass(frozen=True)
class BestLevel:
    """The level with the largest positive δ against the matched baseline in a leaky mode.

    Attributes
    ----------
    reading : int
    leakage_flow, bulk_modulus : float
        Leakage level [m³/s] and β [Pa].
    level : int or None
        Position of the level; None where no δ is positive, or the run is missing or failed.
    delta : float
        Its δ [%].
    is_open : bool
        Whether the run is missing or failed.
    """

    reading: int
    leakage_flow: float
    bulk_modulus: float
    level: int | None
    delta: float
    is_open: bool


def sealed_alarms(grid: ModeGrid) -> tuple[SealedAlarm, ...]:
    """The d3 rule on the sealed runs above the normal EBM."""
    if grid.n_level <= D3:
        return ()
    return tuple(
        _sealed_alarm(grid, reading, beta)
        for reading in range(len(grid.readings))
        for beta in grid.raised
        if grid.positions[reading, 0, beta] != ABSENT
    )


def _sealed_alarm(grid: ModeGrid, reading: int, beta: int) -> SealedAlarm:
    delta = grid.fixed[reading, 0, beta]
    alarm = None if np.isnan(delta).any() else largest_positive(delta.tolist()) == D3
    return SealedAlarm(reading, grid.bulk_moduli[beta], tuple(delta.tolist()), alarm)


def best_levels(grid: ModeGrid) -> tuple[BestLevel, ...]:
    """The best level of each leaky mode under the matched baseline."""
    return tuple(
        _best_level(grid, reading, q, b) for reading in range(len(grid.readings)) for q, b in grid.modes()
    )


def _best_level(grid: ModeGrid, reading: int, q: int, b: int) -> BestLevel:
    delta = grid.matched[reading, 1 + q, b].tolist()
    level = largest_positive(delta)
    value = float("nan") if level is None else delta[level]
    is_open = any(math.isnan(number) for number in delta)
    return BestLevel(reading, grid.leakage_flows[q], grid.bulk_moduli[b], level, value, is_open)


def alarm_matrix(grid: ModeGrid) -> NDArray[np.bool_]:
    """Whether the d3 rule alarms on the sealed actuator, shape (n_reading, n_raised)."""
    delta = grid.fixed[:, 0, grid.raised]
    with np.errstate(invalid="ignore"):
        alarms: NDArray[np.bool_] = (delta[..., D3] > 0.0) & (delta.argmax(axis=-1) == D3)
    return alarms


def best_level_matrix(grid: ModeGrid) -> NDArray[np.int64]:
    """Best level under the matched baseline, −1 where none is positive, shape (n_reading, n_mode)."""
    delta = np.stack([grid.matched[:, 1 + q, b] for q, b in grid.modes()], axis=1)
    best = np.where(np.isnan(delta), -np.inf, delta)
    return np.where(best.max(axis=-1) > 0.0, best.argmax(axis=-1), -1)
