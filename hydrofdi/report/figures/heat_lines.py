"""Lines of the heat map: one run each, or, for many runs, medians for each value of a varied parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.config.shown_values import shown_parameter
from hydrofdi.report.axes import MOST_VALUES, fifths
from hydrofdi.report.document import group_breaks
from hydrofdi.report.runs import EXTERNAL, Levels, RunTable, TableRow
from hydrofdi.report.sections.runs import delta_of
from hydrofdi.report.wording import external_columns, flow_text, leakage_label

MOST_LINES = 60
"""Largest number of runs with one line each, and of lines of a summary."""

_Changes = dict[str, list[Levels]]
"""Kind of baseline → δ of each level [%], line by line."""


@dataclass(frozen=True)
class HeatLines:
    """The columns beside the cells of the heat map, and the cells.

    Attributes
    ----------
    headers : tuple of str
        Above the columns beside the cells, with units.
    texts : tuple of tuple of str
        These columns, line by line.
    changes : dict
        Kind of baseline → δ of each level [%], line by line.
    breaks, strong_breaks : tuple of int
        Lines with a thin or a thick rule above them.
    note : str
        Meaning of a line; empty if each line is a run.
    """

    headers: tuple[str, ...]
    texts: tuple[tuple[str, ...], ...]
    changes: _Changes
    breaks: tuple[int, ...]
    strong_breaks: tuple[int, ...] = ()
    note: str = ""


@dataclass(frozen=True)
class _Column:
    """Varied parameter: its header, the value of each row and its text, and the text of any value."""

    header: str
    values: list[Any]
    texts: list[str]
    text: Callable[[float], str]


def heat_lines(table: RunTable, baselines: Sequence[str]) -> HeatLines:
    """One line per row of a table; for more than `MOST_LINES` rows, medians for each value.

    Parameters
    ----------
    table : RunTable
    baselines : sequence of str
        What δ is taken against.
    """
    rows, columns = table.rows, _columns(table)
    changes = {name: [*map(delta_of("details", name), rows)] for name in baselines}
    make = _runs if len(rows) <= MOST_LINES else _medians
    return make(rows, columns, changes)


def _columns(table: RunTable) -> list[_Column]:
    """Leakage, and the other columns that differ between rows."""
    rows = table.rows
    flows = [row.leakage_flow for row in rows]
    columns = [_Column("leakage [L/min]", flows, list(map(leakage_label, rows)), flow_text)]
    columns.append(_parameter("fluid.bulk_modulus", [row.bulk_modulus for row in rows], "EBM"))
    for chamber, column in enumerate(external_columns(rows) if table.varies_external else ()):
        flows = [row.external_flows[chamber] for row in rows]
        columns.append(_Column(column.heading, flows, [*column.values], flow_text))
    for name in table.label_names:
        if not name.startswith(EXTERNAL):
            columns.append(_parameter(name, [row.labels[name] for row in rows], name))
    leakage, *others = columns
    return [leakage, *(column for column in others if len(set(column.texts)) > 1)]


def _parameter(name: str, values: list[Any], title: str) -> _Column:
    shown = shown_parameter(name, values)
    return _Column(
        shown.header.replace(name, title), values, [shown.text(value) for value in values], shown.text
    )


def _runs(rows: Sequence[TableRow], columns: Sequence[_Column], changes: _Changes) -> HeatLines:
    breaks = group_breaks([row.leakage_request for row in rows])
    return HeatLines(
        headers=tuple(column.header for column in columns),
        texts=tuple(zip(*(column.texts for column in columns), strict=True)),
        changes=changes,
        breaks=breaks,
        strong_breaks=tuple(place for place in breaks if rows[place - 1].is_sealed),
    )


def _medians(rows: Sequence[TableRow], columns: Sequence[_Column], of_runs: _Changes) -> HeatLines:
    """A line for each value of each column, or each fifth of its values, over the rows that leak."""
    sealed = np.array([row.is_sealed for row in rows])
    compared = ~sealed if not sealed.all() else sealed
    changes = {name: np.array(levels) for name, levels in of_runs.items()}
    leakage, *others = columns
    parts = [_groups(leakage, compared)] + [_groups(column, compared) for column in others]
    if sealed.any() and compared is not sealed:
        parts[0].insert(0, ("sealed", sealed))
    kept = _foremost(parts, changes)
    texts: list[tuple[str, ...]] = []
    breaks: list[int] = []
    members: list[Any] = []
    for place in kept:
        breaks.append(len(texts))
        for text, chosen in parts[place]:
            header = columns[place].header if len(texts) == breaks[-1] else ""
            texts.append((header, text, f"{int(chosen.sum()):,}"))
            members.append(chosen)
    return HeatLines(
        headers=("what varies", "value", "runs"),
        texts=tuple(texts),
        changes={name: [_median(of_all[chosen]) for chosen in members] for name, of_all in changes.items()},
        breaks=tuple(breaks[1:]),
        strong_breaks=(1,) if texts[0][1] == "sealed" else (),
        note=_note(len(rows), sealed, len(kept), len(columns)),
    )


def _groups(column: _Column, among: Any) -> list[tuple[str, Any]]:
    """Text → its rows: the rows with each value, or in each fifth of many values."""
    texts, values = np.array(column.texts, dtype=object), column.values
    distinct = list(dict.fromkeys(text for text, is_in in zip(texts, among, strict=True) if is_in))
    if len(distinct) > MOST_VALUES and all(isinstance(value, int | float) for value in values):
        numbers = np.where(among, np.array(values, dtype=float), np.nan)
        chosen = np.flatnonzero(np.isfinite(numbers))
        found = []
        for fifth in fifths(numbers[chosen]):
            own = np.zeros(len(values), dtype=bool)
            own[chosen[fifth.members]] = True
            found.append((f"{column.text(fifth.low)} … {column.text(fifth.high)}", own))
        return found
    named, rest = distinct[:MOST_VALUES], distinct[MOST_VALUES:]
    found = [(text, among & (texts == text)) for text in named]
    return [*found, *([(f"{len(rest)} others", among & np.isin(texts, rest))] if rest else [])]


def _foremost(parts: list[list[tuple[str, Any]]], changes: dict[str, Any]) -> list[int]:
    """Positions of the columns that fit: leakage first, then those with the largest effect on δ."""
    reach = [max(_reach(part, of_all) for of_all in changes.values()) for part in parts]
    kept, n_line = [0], len(parts[0])
    for place in sorted(range(1, len(parts)), key=lambda place: -reach[place]):
        if n_line + len(parts[place]) <= MOST_LINES:
            kept, n_line = [*kept, place], n_line + len(parts[place])
    return sorted(kept)


def _reach(part: list[tuple[str, Any]], of_all: Any) -> float:
    """Largest range of the medians of a column over all levels [percentage points]."""
    medians = np.array([_median(of_all[chosen]) for _, chosen in part])
    spread = np.ptp(medians, axis=0)
    return float(np.max(spread[np.isfinite(spread)], initial=0.0))


def _median(deltas: Any) -> Levels:
    """Median of each level over the runs that have a number."""
    found = [column[np.isfinite(column)] for column in deltas.T]
    return tuple(float(np.median(column)) if column.size else float("nan") for column in found)


def _note(n_run: int, sealed: Any, n_kept: int, n_column: int) -> str:
    of = "runs" if sealed.all() else "leaking runs"
    note = f"{n_run:,} runs in one picture: each row is the median δ of the {of} with this value"
    if sealed.any() and not sealed.all():
        note += "; 'sealed' is the median of the runs without a leak"
    if n_kept < n_column:
        note += f"; shown are the {n_kept} of {n_column} parameters that move δ most"
    return note
