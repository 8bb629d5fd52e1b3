"""The two parameters of a sweep that matter most, and features over their values as matrices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.runs import spread
from hydrofdi.evaluation.scores import comparable
from hydrofdi.report.document import Block
from hydrofdi.report.responses import AGAINST, Axis, Feature, ResponseStudy
from hydrofdi.report.runs import Array, signed
from hydrofdi.settings.messages import number_text
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.tables.table import Column, Table

_LEAST_FILLED = 0.5
"""Share of the cells that have a run, below which points are no plane."""

_MOST_VALUES = 8
"""Most values of a parameter in a table; a figure has all."""


@dataclass(frozen=True)
class Plane:
    """Runs by the values of two parameters; others vary within a cell, which shows the median.

    Attributes
    ----------
    texts : tuple of two lists of str
        The values of the row parameter and the column parameter, ascending.
    headers : tuple of two str
    cell : ndarray of int, shape (n_run,)
        Cell of each run, row by row; −1 for runs that were added for comparison.
    against : str
        Baseline of the changes; empty if the features are no changes.
    features : tuple of Feature
    others : tuple of str
        Further parameters that vary.
    baseline : tuple of two float, or None
        Row and column of the fixed baseline, with fractions between the values; None if it is beyond them, or
        if runs have different ones.
    """

    texts: tuple[list[str], list[str]]
    headers: tuple[str, str]
    cell: NDArray[np.intp]
    against: str
    features: tuple[Feature, ...]
    others: tuple[str, ...]
    baseline: tuple[float, float] | None

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self.texts[0]), len(self.texts[1])

    def matrix(self, feature: Feature) -> Array:
        """The median of a feature in each cell; NaN if no run there has one."""
        matrix = np.full(self.shape, np.nan)
        known = np.isfinite(feature.values) & (self.cell >= 0)
        # Runs sorted by cell, then split where a new cell begins: a median per cell without a loop over runs.
        order = np.argsort(self.cell[known], kind="stable")
        cells, first = np.unique(self.cell[known][order], return_index=True)
        parts = np.split(feature.values[known][order], first[1:])
        matrix.flat[cells] = [np.median(part) for part in parts if part.size]
        return matrix

    @property
    def strongest(self) -> Feature:
        """The feature whose medians have the widest range; of features that are no changes, the first."""
        if not self.features[0].is_change:
            return self.features[0]
        changes = [each for each in self.features if each.is_change]
        # Zero belongs to the range: the baseline itself need not be in the grid.
        ranges = [np.ptp(np.append(0.0, values[np.isfinite(values)])) for values in map(self.matrix, changes)]
        return changes[int(np.argmax(comparable(np.array(ranges))))]

    @property
    def said(self) -> str:
        """What δ is taken against, and that a cell is a median."""
        against = f"δ > 0: the RMS fell, against {AGAINST[self.against]}" if self.against else ""
        medians = f"medians over {', '.join(self.others)}" if self.others else ""
        return "; ".join(filter(None, (against, medians)))


def plane_of(data: ExperimentData, study: ResponseStudy) -> Plane | None:
    """The grid of an experiment over the two parameters that move its features most; None if it has none."""
    responding = [axis for axis in study.axes if axis.responses]
    axes = sorted(responding, key=lambda axis: -max(each.reach for each in axis.responses))
    for pair in combinations(axes, 2):
        rows, columns = sorted(
            pair, key=lambda axis: (not axis.name.startswith("leakage."), axes.index(axis))
        )
        (row_of, row_values), (column_of, column_values) = map(_places, (rows, columns))
        inside = (row_of >= 0) & (column_of >= 0)
        cell = np.where(inside, row_of * len(column_values) + column_of, -1)
        # Parameters that vary together (zip) fill a diagonal only.
        if len(np.unique(cell[inside])) < _LEAST_FILLED * len(row_values) * len(column_values):
            continue
        known = {
            name: any(np.isfinite(each.values).any() for each in own) for name, own in study.details.items()
        }
        against = next((name for name in data.baselines if known[name]), "")
        return Plane(
            ([*map(rows.text, row_values)], [*map(columns.text, column_values)]),
            (rows.header, columns.header),
            cell,
            against,
            (*study.details[against], *study.measured),
            tuple(axis.header for axis in axes if axis not in pair),
            _baseline(data, cell >= 0, {rows.name: row_values, columns.name: column_values}),
        )
    return None


def _places(axis: Axis) -> tuple[NDArray[np.intp], list[Any]]:
    """Number of the value of each run, −1 for none, and all values in order."""
    places = np.full(len(axis.groups[0].rows), -1)
    if axis.numbers is None:
        for number, group in enumerate(axis.groups):
            places[group.rows] = number
        return places, [group.value for group in axis.groups]
    known = np.isfinite(axis.numbers)
    values, places[known] = np.unique(axis.numbers[known], return_inverse=True)
    return places, values.tolist()


def _baseline(
    data: ExperimentData, inside: NDArray[np.bool_], values: Mapping[str, list[Any]]
) -> tuple[float, float] | None:
    row, *others = np.unique(data.fixed_baseline[inside]).tolist()
    if row == names.NO_BASELINE or others:
        return None
    found = []
    for name, own in values.items():
        is_leakage = name in INTERNAL_LEAKAGE_FORMS
        value = data.leakage_requests[row] if is_leakage else data.values(name)[row]
        is_number = all(isinstance(each, int | float) for each in (value, *own))
        if value in own:
            found.append(float(own.index(value)))
        elif is_number and own[0] < value < own[-1]:
            found.append(float(np.interp(value, own, np.arange(len(own)))))
    return (found[0], found[1]) if len(found) == len(values) else None


def matrix_block(plane: Plane) -> Block:
    """The strongest feature as a table over both parameters, and the figure of all."""
    feature, matrix = plane.strongest, plane.matrix(plane.strongest)
    rows, columns = (spread(count, _MOST_VALUES) for count in plane.shape)
    number: Callable[[Any], str] = signed if feature.is_change else number_text
    content = [Column(plane.headers[0], [plane.texts[0][row] for row in rows])]
    for column in columns:
        strong = [k for k, row in enumerate(rows) if (row, column) == plane.baseline]
        name = plane.texts[1][column]
        content.append(Column(name, matrix[rows, column], feature.own_unit, name, number, strong=strong))
    notes = [f"{plane.said}{'; *: the baseline' * (plane.baseline is not None)}."] if plane.said else []
    if (len(rows), len(columns)) != plane.shape:
        n_row, n_column = plane.shape
        notes.append(f"Some of {n_row} × {n_column} cells; --figure sensitivity.png draws all.")
    title = f"{feature.header} by {plane.headers[0]} (rows) and {plane.headers[1]} (columns)"
    table = Table(tuple(content), title, "matrix", tuple(notes))
    return Block("matrix", "Over two parameters", (), (table,), ("sensitivity",), is_answer=True)
