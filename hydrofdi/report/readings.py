"""How much a conclusion hangs on what is not known: claims and controls over the readings of an ensemble."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.claims import CLAIMS, Margin, claim_margins
from hydrofdi.report.controls import alarm_matrix, best_level_matrix
from hydrofdi.report.modes import ABSENT, ModeGrid
from hydrofdi.store import ExperimentData, names
from hydrofdi.store.results import MISSING

Mask = NDArray[np.bool_]
"""One truth value per reading."""

CORE = ("C1", "C2", "C3", "C4")
"""The claims that carry the paper's conclusion."""

_MOST_VALUES = 12
"""Different values up to which a parameter is shown value by value; beyond, in fifths."""

_FIFTHS = 5


@dataclass(frozen=True)
class ValueShare:
    """The readings with one value, or one range of values, of a parameter.

    Attributes
    ----------
    parameters : tuple of str
        Dotted names; several where they vary together.
    values : tuple
        A value in SI for each, or the ends of a range of a single parameter.
    is_range : bool
        Whether `values` are the ends of a range.
    members : ndarray of bool, shape (n_reading,)
    """

    parameters: tuple[str, ...]
    values: tuple[Any, ...]
    is_range: bool
    members: Mask


@dataclass(frozen=True)
class ReadingsStudy:
    """Claims and controls over all readings.

    Attributes
    ----------
    grid : ModeGrid
    outcomes : tuple of str, length n_reading
        ``ok`` where all runs of a reading ended well, else the status of the first that did not.
    margins : dict
        Claim → margin in every reading [percentage points].
    alarms : ndarray of bool, shape (n_reading, n_raised)
        Whether the d3 rule alarms on the sealed actuator at each β above the normal one.
    best_levels : ndarray of int, shape (n_reading, n_mode)
        Position of the best level of each leaky mode under the matched baseline; −1 where there is none.
    """

    grid: ModeGrid
    outcomes: tuple[str, ...]
    margins: dict[str, Margin]
    alarms: Mask
    best_levels: NDArray[np.int64]

    @property
    def n_reading(self) -> int:
        """Number of different readings."""
        return len(self.outcomes)

    @cached_property
    def feasible(self) -> Mask:
        """Readings of which all runs ended well."""
        return np.array([outcome == "ok" for outcome in self.outcomes])

    @property
    def obstacles(self) -> dict[str, int]:
        """Status → number of readings that it made infeasible, or that are not computed yet."""
        return dict(sorted(Counter(outcome for outcome in self.outcomes if outcome != "ok").items()))

    def reproducing(self, claims: tuple[str, ...]) -> Mask:
        """Feasible readings in which all of these claims hold."""
        with np.errstate(invalid="ignore"):
            held = [self.margins[claim] > 0.0 for claim in claims]
        mask: Mask = np.logical_and.reduce([self.feasible, *held])
        return mask

    def decided(self, claims: tuple[str, ...]) -> Mask:
        """Feasible readings that say whether all of these claims hold: they do, or one of them does not."""
        with np.errstate(invalid="ignore"):
            failed = [self.margins[claim] <= 0.0 for claim in claims]
        mask: Mask = self.feasible & np.logical_or.reduce(failed)
        return mask | self.reproducing(claims)

    def is_open(self, claims: tuple[str, ...]) -> bool:
        """Whether one of these claims cannot be tested in any feasible reading, and none fails in all."""
        untested = [np.isnan(self.margins[claim][self.feasible]).all() for claim in claims]
        return any(untested) and not np.array_equal(self.decided(claims), self.feasible)

    @property
    def claim_sets(self) -> dict[str, tuple[str, ...]]:
        """Name → claims: each by itself, then together."""
        single = {claim.id: (claim.id,) for claim in CLAIMS}
        every = tuple(single)
        return single | {"C1–C4": CORE, "C1–C5": every[:5], "C1–C6": every}

    @cached_property
    def value_shares(self) -> tuple[ValueShare, ...]:
        """The readings by the values of each parameter."""
        return tuple(share for group in _varying_together(self.grid) for share in _shares(self.grid, group))


def study_readings(grid: ModeGrid, data: ExperimentData) -> ReadingsStudy:
    """Evaluate claims and controls in every reading.

    Parameters
    ----------
    grid : ModeGrid
        Made from `data`.
    data : ExperimentData
        An experiment with an ``ensemble``.
    """
    statuses = np.asarray(data.columns[names.STATUS]).astype(str)
    outcomes = tuple(_outcome(statuses, positions) for positions in grid.positions)
    return ReadingsStudy(grid, outcomes, claim_margins(grid), alarm_matrix(grid), best_level_matrix(grid))


def _outcome(statuses: NDArray[Any], positions: NDArray[np.int64]) -> str:
    found = [str(statuses[position]) for position in positions.ravel() if position != ABSENT]
    bad = [status for status in found if status != "ok"]
    return MISSING if MISSING in bad else next(iter(bad), "ok")


def _varying_together(grid: ModeGrid) -> list[tuple[str, ...]]:
    """Parameters, those of which one determines the other taken together."""
    groups: dict[tuple[int, ...], list[str]] = {}
    for name in grid.readings[0]:
        order: dict[Any, int] = {}
        codes = tuple(order.setdefault(reading[name], len(order)) for reading in grid.readings)
        groups.setdefault(codes if len(order) <= _MOST_VALUES else (len(groups), -1), []).append(name)
    return [tuple(group) for group in groups.values()]


def _shares(grid: ModeGrid, group: tuple[str, ...]) -> list[ValueShare]:
    rows = [tuple(reading[name] for name in group) for reading in grid.readings]
    different = sorted(set(rows), key=_order)
    if len(different) <= _MOST_VALUES:
        return [ValueShare(group, row, False, np.array([r == row for r in rows])) for row in different]
    values = np.array([row[0] for row in rows], dtype=float)
    edges = np.quantile(values, np.linspace(0.0, 1.0, _FIFTHS + 1))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, _FIFTHS - 1)
    return [
        ValueShare(group, (float(edges[k]), float(edges[k + 1])), True, place == k) for k in range(_FIFTHS)
    ]


def _order(row: tuple[Any, ...]) -> tuple[bool, float, str]:
    first = row[0]
    is_text = first is None or isinstance(first, str)
    return is_text, 0.0 if is_text else float(first), str(first)
