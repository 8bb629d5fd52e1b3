"""Distinct rows of a table of integers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_LARGEST_KEY = 2**62


def distinct_rows(
    columns: Sequence[NDArray[np.int32]], n_row: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Distinct rows of columns of integers (-1 or greater), in order of first appearance.

    Parameters
    ----------
    columns : sequence of int arrays, shape (n_row,)
    n_row : int

    Returns
    -------
    first : array of int, shape (n_distinct,)
        Row in which each distinct row first appears.
    inverse : array of int, shape (n_row,)
        Index of the distinct row that each row equals.
    """
    key, n_key = np.zeros(n_row, dtype=np.int64), 1
    for column in columns:
        size = int(column.max(initial=-1)) + 2
        if size * n_key > _LARGEST_KEY:
            _, key = np.unique(key, return_inverse=True)
            n_key = n_row
        key, n_key = key * size + (column + 1), n_key * size
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]
