"""The scenarios by the values of each parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.grid.modes import ModeGrid
from hydrofdi.report.axes import MOST_VALUES, fifths

Mask = NDArray[np.bool_]
"""One truth value per scenario."""


@dataclass(frozen=True)
class ValueShare:
    """The scenarios with one value, or one range of values, of a parameter.

    Attributes
    ----------
    parameters : tuple of str
        Dotted names; several where they vary together.
    values : tuple
        A value in SI for each, or the ends of a range of a single parameter.
    is_range : bool
        Whether `values` are the ends of a range.
    members : ndarray of bool, shape (n_scenario,)
    """

    parameters: tuple[str, ...]
    values: tuple[Any, ...]
    is_range: bool
    members: Mask


def value_shares(grid: ModeGrid) -> tuple[ValueShare, ...]:
    """The scenarios by the values of each parameter; parameters that vary together count as one."""
    return tuple(share for group in _varying_together(grid) for share in _shares(grid, group))


def _varying_together(grid: ModeGrid) -> list[tuple[str, ...]]:
    """Parameters, those of which one determines the other count as one."""
    groups: dict[tuple[int, ...], list[str]] = {}
    for name in grid.scenarios[0]:
        order: dict[Any, int] = {}
        codes = tuple(order.setdefault(scenario[name], len(order)) for scenario in grid.scenarios)
        groups.setdefault(codes if len(order) <= MOST_VALUES else (len(groups), -1), []).append(name)
    return [tuple(group) for group in groups.values()]


def _shares(grid: ModeGrid, group: tuple[str, ...]) -> list[ValueShare]:
    rows = [tuple(scenario[name] for name in group) for scenario in grid.scenarios]
    different = sorted(set(rows), key=_order)
    if len(different) <= MOST_VALUES:
        return [ValueShare(group, row, False, np.array([r == row for r in rows])) for row in different]
    values = np.array([row[0] for row in rows], dtype=float)
    return [ValueShare(group, (part.low, part.high), True, part.members) for part in fifths(values)]


def _order(row: tuple[Any, ...]) -> tuple[bool, float, str]:
    first = row[0]
    is_text = first is None or isinstance(first, str)
    return is_text, 0.0 if is_text else float(first), str(first)
