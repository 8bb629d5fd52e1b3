"""Quantiles in place of many rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.document import Cell, Sheet
from hydrofdi.report.wording import HOLE, signed

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Quantiles that are shown in place of the numbers of many runs."""

MANY_ROWS = 60
"""Most rows of a table that is shown in full."""


def quantiles_sheet(
    key: str,
    title: str,
    what: str,
    rows: Mapping[str, NDArray[np.float64]],
    text: Callable[[str, float], str] = lambda _, value: signed(value),
) -> Sheet:
    """A table of quantiles.

    Parameters
    ----------
    key, title : str
    what : str
        Header of the first column.
    rows : mapping of str to ndarray, shape (n_run,)
        What stands in the first column → numbers; NaN if a run has none.
    text : callable
        First column and number → what people read.
    """
    return Sheet(
        key,
        title,
        (what, *(f"{100 * share:g} %" for share in QUANTILES), "Runs"),
        tuple(_cells(name, values[np.isfinite(values)], text) for name, values in rows.items()),
        text_columns=(0,),
    )


def _cells(name: str, known: NDArray[np.float64], text: Callable[[str, float], str]) -> tuple[Cell, ...]:
    values = np.quantile(known, QUANTILES).tolist() if known.size else []
    shown = [Cell(text(name, value), value=value) for value in values] or [Cell(HOLE)] * len(QUANTILES)
    return (Cell(name), *shown, Cell(f"{known.size:,}", value=known.size))
