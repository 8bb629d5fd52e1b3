"""The hydraulic modes of inspected runs on the terminal."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hydrofdi.cli.parted_table import PartedTable
from hydrofdi.cli.terminal import terminal
from hydrofdi.report.wording import labels_text, shown_modulus
from hydrofdi.settings.counting import counted
from hydrofdi.units import convert

if TYPE_CHECKING:
    from hydrofdi.api.inspection import Inspection, ModeOfRun

_MOST_ROWS = 24
"""Most runs that have a row each; for more, such as a sample, the ranges are shown."""

Column = tuple[Callable[["ModeOfRun"], float], str]
"""Number of a run, and its format."""

_OTHERS: dict[str, Column] = {
    "K_i\nm³/s/√Pa": (lambda mode: mode.leakage_coefficient, ".3g"),
    "leakage\nL/min": (lambda mode: convert(mode.mean_leakage_flow, "L/min"), ".3g"),
    "of piston\nflow": (lambda mode: mode.piston_share, ".1%"),
    "at 8 MPa\nL/min": (lambda mode: convert(mode.leakage_flow_at_reference, "L/min"), ".3g"),
    "f_h\nHz": (lambda mode: mode.frequency, ".1f"),
    "ζ\n": (lambda mode: mode.damping_ratio, ".4f"),
    "octaves\nto edge": (lambda mode: mode.octaves_to_edge, ".2f"),
    "stroke\nused": (lambda mode: mode.stroke_share, ".0%"),
}
"""Header → column, without the EBM."""

_LEADING = 3
"""Columns that distinguish runs."""


def print_modes(found: Inspection) -> None:
    """Print a row for each run and further parameters below, or the ranges of many runs."""
    console = terminal()
    if len(found.modes) > _MOST_ROWS:
        console.print(_ranges(found))
        console.print(f"of {counted(len(found.modes), 'run')}; --json lists each")
        return
    console.print(_rows(found))
    for text, number in _condition_marks(found).items():
        if text:
            console.print(f"({number}) {text}")


def _columns() -> dict[str, Column]:
    """Header → column; the EBM in the user's unit."""
    modulus = shown_modulus()
    return {f"EBM\n{modulus.unit}": (lambda mode: modulus.number(mode.bulk_modulus), "g"), **_OTHERS}


def _rows(found: Inspection) -> PartedTable:
    marks, columns = _condition_marks(found), _columns()
    headers = list(columns)
    more = ["see\nbelow"] if len(marks) > 1 else []
    shown = PartedTable([*headers[:-2], "band\n", *headers[-2:], *more], _LEADING)
    for mode in found.modes:
        cells = [cell(number(mode), form) for number, form in columns.values()]
        band = _band_name(mode.level, len(found.bands)) if mode.status == "ok" else mode.status
        mark = [f"({marks[labels_text(mode.labels)]})"] if len(marks) > 1 else []
        shown.add_row(*cells[:-2], band, *cells[-2:], *mark)
    return shown


def _ranges(found: Inspection) -> PartedTable:
    columns = _columns()
    shown = PartedTable(["", *columns])
    numbers = np.array([[number(mode) for number, _ in columns.values()] for mode in found.modes])
    for name, place in (("least", 0.0), ("median", 0.5), ("largest", 1.0)):
        row = [_quantile(own[np.isfinite(own)], place) for own in numbers.T]
        forms = (form for _, form in columns.values())
        shown.add_row(name, *(cell(value, form) for value, form in zip(row, forms, strict=True)))
    return shown


def _quantile(values: NDArray[np.float64], place: float) -> float:
    return float(np.quantile(values, place)) if values.size else math.nan


def _condition_marks(found: Inspection) -> dict[str, int]:
    """Further parameters as text → their number in the table, in order of appearance."""
    texts = dict.fromkeys(labels_text(mode.labels) for mode in found.modes)
    return {text: number for number, text in enumerate(texts, 1)}


def _band_name(level: int, n_level: int) -> str:
    if level == 0:
        return "above d1"
    return f"d{level}" if level <= n_level else f"below d{n_level}"


def cell(value: float, form: str) -> str:
    """A number; a dash if there is none."""
    return format(value, form) if math.isfinite(value) else "–"
