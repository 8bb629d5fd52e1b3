"""Two controls that the paper does not have: the rule on a sealed actuator, and the matched baseline."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.claims import D3
from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.report.runs import Levels, RunTable, TableRow, largest_positive


@dataclass(frozen=True)
class SealedAlarm:
    """What the d3 rule says of an actuator without any leak, at an EBM above normal.

    Attributes
    ----------
    position : int
        Row of the run in the experiment.
    labels : dict
        Further varied parameters → their values in SI.
    bulk_modulus : float
        β [Pa].
    delta_fixed : tuple of float
        δ of all levels against the fixed baseline [%].
    alarm : bool or None
        Whether δd3 is positive and the largest; None if the run is missing or failed.
    """

    position: int
    labels: dict[str, Any]
    bulk_modulus: float
    delta_fixed: Levels
    alarm: bool | None


@dataclass(frozen=True)
class BestLevel:
    """The level with the largest positive δ against the matched baseline in a leaky mode.

    Attributes
    ----------
    position : int
        Row of the run in the experiment.
    labels : dict
        Further varied parameters → their values in SI.
    leakage_flow, bulk_modulus : float
        Leakage level [m³/s] and β [Pa].
    level : int or None
        Position of the level; None if no δ is positive, or the run is missing or failed.
    delta : float
        Its δ [%].
    is_open : bool
        Whether the run is missing or failed.
    """

    position: int
    labels: dict[str, Any]
    leakage_flow: float
    bulk_modulus: float
    level: int | None
    delta: float
    is_open: bool


def sealed_alarms(table: RunTable) -> tuple[SealedAlarm, ...]:
    """The d3 rule on the sealed runs above the normal EBM."""
    if table.n_level <= D3:
        return ()
    normal = table.normal_bulk_modulus
    return tuple(
        _sealed_alarm(row, labels)
        for row, labels in _controlled(table)
        if row.is_sealed and row.bulk_modulus > normal
    )


def _sealed_alarm(row: TableRow, labels: dict[str, Any]) -> SealedAlarm:
    is_open = any(math.isnan(number) for number in row.details.fixed)
    alarm = None if is_open else largest_positive(row.details.fixed) == D3
    return SealedAlarm(row.position, labels, row.bulk_modulus, row.details.fixed, alarm)


def best_levels(table: RunTable) -> tuple[BestLevel, ...]:
    """The best level of each leaky run under the matched baseline."""
    return tuple(_best_level(row, labels) for row, labels in _controlled(table) if not row.is_sealed)


def _best_level(row: TableRow, labels: dict[str, Any]) -> BestLevel:
    level = largest_positive(row.details.matched)
    value = math.nan if level is None else row.details.matched[level]
    is_open = any(math.isnan(number) for number in row.details.matched)
    return BestLevel(row.position, labels, row.leakage_flow, row.bulk_modulus, level, value, is_open)


def _controlled(table: RunTable) -> list[tuple[TableRow, dict[str, Any]]]:
    """The rows without further external leakage by labels, leakage and EBM, with the labels that vary."""
    rows = [row for row in table.rows if not row.leaks_out_more]
    varied = [name for name in table.label_names if len({row.labels[name] for row in rows}) > 1]
    pairs = [(row, {name: row.labels[name] for name in varied}) for row in rows]
    order = {key: place for place, key in enumerate(dict.fromkeys(tuple(p[1].values()) for p in pairs))}
    return sorted(pairs, key=lambda p: (order[tuple(p[1].values())], p[0].leakage_request, p[0].bulk_modulus))


def alarm_matrix(grid: ModeGrid) -> NDArray[np.bool_]:
    """Whether the d3 rule alarms on the sealed actuator, shape (n_scenario, n_raised)."""
    delta = grid.fixed[:, 0, grid.raised]
    with np.errstate(invalid="ignore"):
        alarms: NDArray[np.bool_] = (delta[..., D3] > 0.0) & (delta.argmax(axis=-1) == D3)
    return alarms


def best_level_matrix(grid: ModeGrid) -> NDArray[np.int64]:
    """Best level under the matched baseline, −1 where none is positive, shape (n_scenario, n_mode)."""
    delta = np.stack([grid.matched[:, 1 + q, b] for q, b in grid.modes()], axis=1)
    best = np.where(np.isnan(delta), -np.inf, delta)
    return np.where(best.max(axis=-1) > 0.0, best.argmax(axis=-1), -1)
