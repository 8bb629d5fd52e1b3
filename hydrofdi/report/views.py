"""Views of a sweep: over two parameters, of external leakage, and of how healthy actuators differ.

External leakage: does an approximation separate it from internal leakage and from a change of EBM? After
Goharrizi and Sepehri, International Journal of Fluid Power, who use the level-4 approximation. Its RMS is the
choice made here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.runs import spread
from hydrofdi.evaluation.scores import comparable
from hydrofdi.report.document import Block
from hydrofdi.report.indicators import span_of
from hydrofdi.report.responses import AGAINST, ResponseStudy, RunFeature, VariedParameter
from hydrofdi.report.runs import EXTERNAL, Array, ReportedRuns, joined, lead_columns, signed, span_text
from hydrofdi.settings.messages import number_text
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.tables.table import Column, Table, finite
from hydrofdi.transforms import percentage_change

View = tuple[Block, dict[str, Any]]

_SEED = "measurement.seed"

_D2, _LEVEL = 1, 3
"""Positions of d2, and of a4; the deepest level if there are fewer."""


def external_view(table: ReportedRuns) -> View | None:
    """Ranges of δ with the same leaky chambers, and how far they are from those without external leakage.

    δ is against the fixed, δ′ against the matched baseline: of the settled records if there are any. A gap
    below zero means that the ranges overlap, so that no threshold separates them.
    """
    if not any(name.startswith(EXTERNAL) for name in table.label_names):
        return None
    level = min(_LEVEL, table.n_level - 1)
    deltas = _deltas(table, level)
    leaks = [tuple((np.flatnonzero(row > 0.0) + 1).tolist()) for row in table.external_coefficients]
    states = {state: [each == state for each in leaks] for state in sorted({(), *leaks})}
    spans = {name: [span_of(own[rows]) for rows in states.values()] for name, own in deltas.items()}
    gaps = {
        name: [max(low - quiet[1], quiet[0] - high) for low, high in (quiet, *others)]
        for name, (quiet, *others) in spans.items()
    }
    record = [
        {
            "external_leakage_of": list(chambers),
            "runs": sum(rows),
            "ranges_percent": {name: list(map(finite, own[index])) for name, own in spans.items()},
            "gap_percentage_points": {name: finite(own[index]) for name, own in gaps.items()},
        }
        for index, (chambers, rows) in enumerate(states.items())
    ]
    titles = [" and ".join(map(str, chambers)) or "none" for chambers in states]
    columns = [Column("Out of chamber", titles, is_text=True), Column("Runs", [*map(sum, states.values())])]
    for name, own in spans.items():
        apart = [math.nan, *gaps[name][1:]]
        strong = [k for k, gap in enumerate(apart) if gap > 0.0]
        columns.append(Column(f"{name} [%]", [span_text(*map(signed, span)) for span in own]))
        columns.append(Column(f"Gap {name}", apart, text=signed, strong=strong))
    note = (
        "δ against the fixed, δ′ against the matched baseline. Gap: percentage points between the range and"
        " that of runs without external leakage; below zero they overlap."
    )
    named = any(name.startswith(EXTERNAL) for name in table.data.experiment.baseline)
    lack = "The baseline names no external leakage, so δ does not show it: put"
    said = () if named else (f"{lack} {EXTERNAL}_1: 0 and _2: 0 into the baseline.",)
    title = f"External leakage by the approximation a{level + 1}"
    sheet = Table(tuple(columns), "Ranges over all internal leakages and EBM", "external-ranges", (note,))
    block = Block("external", title, said, (sheet,), is_answer=True)
    return block, {"external_leakage": {"approximation": f"a{level + 1}", "states": record}}


def _deltas(table: ReportedRuns, level: int) -> dict[str, Array]:
    """δ and δ′ [%] of the approximation, and of d2."""
    kinds = {f"a{level + 1}": (names.APPROXIMATION_RMS, level)}
    if level >= _D2:
        kinds["d2"] = (names.DETAIL_RMS, _D2)
    return {
        f"{sign}{name}": table.changes(baseline, table.settled(rms))[:, at]
        for name, (rms, at) in kinds.items()
        for sign, baseline in (("δ", "fixed"), ("δ′", "matched"))
    }


def healthy_view(table: ReportedRuns) -> View | None:
    """Does a leak move the details more than sealed actuators differ by what is drawn, and by their noise?"""
    sweep = table.data.experiment.sweep
    chance = sweep.drawn | ({_SEED} & {*sweep.names})
    if not chance or chance & {"fluid.bulk_modulus", *INTERNAL_LEAKAGE_FORMS}:
        return None
    labels = tuple(name for name in table.label_names if name not in chance)
    groups = [*_against_sealed(replace(table, label_names=labels))]
    if not groups:
        return None
    first = replace(table.of([rows[0] for rows, _ in groups]), label_names=labels)
    spans = np.array([(delta.min(axis=0), delta.max(axis=0)) for _, delta in groups])
    sealed = spans[np.maximum.accumulate(np.where(first.is_sealed, np.arange(len(first)), 0))]
    beyond = (spans[:, 0] > sealed[:, 1]) | (spans[:, 1] < sealed[:, 0])
    lead = [*lead_columns(first), Column("Runs", [len(rows) for rows, _ in groups])]
    levels = (
        Column(
            f"δd{level} [%]",
            [span_text(*map(signed, ends)) for ends in spans[:, :, level - 1].tolist()],
            strong=np.flatnonzero(beyond[:, level - 1]).tolist(),
        )
        for level in range(1, table.n_level + 1)
    )
    said = (
        f"{'Settled records' if table.has_settled else 'Records'} of actuators that differ in"
        f" {joined(sorted(chance))}. δ is against the mean of the sealed ones; of each of these, against the"
        " mean of the others. Another one would lie outside of the range of n in about 2 of n + 1 cases."
        " Emphasized: the whole range lies outside of that of the sealed ones."
    )
    breaks = np.flatnonzero(first.is_sealed)[1:].tolist()
    sheet = Table((*lead, *levels), "Ranges of δ", "healthy-ranges", breaks=breaks, n_lead=len(lead))
    block = Block("healthy", "Leaks against what differs without a leak", (said,), (sheet,), is_answer=True)
    record = [
        {"run_id": table.of(rows).texts(names.RUN_ID), "delta_percent": delta.tolist()}
        for rows, delta in groups
    ]
    return block, {"healthy_ranges": record}


def _against_sealed(table: ReportedRuns) -> Iterator[tuple[NDArray[np.intp], Array]]:
    """Rows and δ of the sealed runs, then of each leak, where several sealed runs have the same labels."""
    rms = table[table.settled(names.DETAIL_RMS)]
    known, leaks = np.isfinite(rms).all(axis=1), table.leakage_requests
    values = (table[names.BULK_MODULUS].tolist(), *map(table.values, table.label_names))
    conditions = list(zip(*values, strict=True))
    for condition in dict.fromkeys(conditions):
        own = known & np.array([each == condition for each in conditions])
        sealed = rms[own & (leaks == 0.0)]
        for leak in np.unique(leaks[own]) if len(sealed) > 1 else ():
            rows = np.flatnonzero(own & (leaks == leak))
            others = (sealed.sum(axis=0) - sealed) / (len(sealed) - 1)
            yield rows, percentage_change(sealed.mean(axis=0) if leak else others, rms[rows])


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
    features : tuple of RunFeature
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
    features: tuple[RunFeature, ...]
    others: tuple[str, ...]
    baseline: tuple[float, float] | None

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self.texts[0]), len(self.texts[1])

    def matrix(self, feature: RunFeature) -> Array:
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
    def strongest(self) -> RunFeature:
        """The feature whose medians have the widest range; of features that are no changes, the first."""
        if not self.features[0].is_change:
            return self.features[0]
        changes = [feature for feature in self.features if feature.is_change]
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
    axes = sorted(responding, key=lambda axis: -max(response.reach for response in axis.responses))
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


def _places(axis: VariedParameter) -> tuple[NDArray[np.intp], list[Any]]:
    """Number of the value of each run, −1 for none, and all values in order."""
    index = np.full(len(axis.groups[0].rows), -1)
    if axis.numbers is None:
        for number, group in enumerate(axis.groups):
            index[group.rows] = number
        return index, [group.value for group in axis.groups]
    known = np.isfinite(axis.numbers)
    values, index[known] = np.unique(axis.numbers[known], return_inverse=True)
    return index, values.tolist()


def _baseline(
    data: ExperimentData, inside: NDArray[np.bool_], values: Mapping[str, list[Any]]
) -> tuple[float, float] | None:
    row, *others = np.unique(data.fixed_baseline[inside]).tolist()
    if row == names.NO_BASELINE or others:
        return None
    position = []
    for name, own in values.items():
        is_leakage = name in INTERNAL_LEAKAGE_FORMS
        value = data.leakage_requests[row] if is_leakage else data.values(name)[row]
        is_number = all(isinstance(each, int | float) for each in (value, *own))
        if value in own:
            position.append(float(own.index(value)))
        elif is_number and own[0] < value < own[-1]:
            position.append(float(np.interp(value, own, np.arange(len(own)))))
    return (position[0], position[1]) if len(position) == len(values) else None


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
    notes = [f"{plane.said}{'; marked: the baseline' * (plane.baseline is not None)}."] if plane.said else []
    if (len(rows), len(columns)) != plane.shape:
        n_row, n_column = plane.shape
        notes.append(f"Some of {n_row} × {n_column} cells; --figure sensitivity.png draws all.")
    title = f"{feature.header} by {plane.headers[0]} (rows) and {plane.headers[1]} (columns)"
    table = Table(tuple(content), title, "matrix", tuple(notes))
    return Block("matrix", "Over two parameters", (), (table,), ("sensitivity",), is_answer=True)
