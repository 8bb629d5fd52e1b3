"""Truncated rows of a text: their last number may be incomplete."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hydrofdi.records.batch import Array


def broken_rows(widths: Sequence[int], n_column: int) -> list[int]:
    """Rows with fewer cells than usual in the file, which may leave its last column empty."""
    usual = _usual(widths, n_column)
    return [row for row, width in enumerate(widths) if width < usual]


def rows_to_keep(widths: Sequence[int], n_column: int, *, is_ended: bool) -> int:
    """Number of rows up to the last complete one; at least one.

    Parameters
    ----------
    widths : sequence of int
        Cells of each row.
    n_column : int
        Columns with a name.
    is_ended : bool
        Whether the last row has a line end.
    """
    usual, kept = _usual(widths, n_column), len(widths)
    if kept > 1 and not is_ended and widths[-1] < widths[-2]:
        kept -= 1
    while kept > 1 and widths[kept - 1] < usual:
        kept -= 1
    return kept


def bridged(times: Array, rows: Sequence[int]) -> Array:
    """Instants, interpolated linearly in some rows; NaN if a row has no neighbour on one side."""
    if not rows:
        return times
    whole = np.delete(np.arange(times.size), rows)
    times[rows] = np.interp(rows, whole, times[whole], left=np.nan, right=np.nan)
    return times


def _usual(widths: Sequence[int], n_column: int) -> int:
    """The most frequent number of cells, at most `n_column`; the larger of equally frequent numbers."""
    counts = Counter(widths)
    return min(n_column, max(counts, key=lambda width: (counts[width], width), default=0))
