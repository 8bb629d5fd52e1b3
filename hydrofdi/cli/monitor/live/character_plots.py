"""Plots of characters: braille, or points if the terminal shows only ASCII."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records.batch import Array

_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""Bits of the braille characters: four rows of two dots."""

_POINTS = " '.:"
"""Characters of two rows of one dot, for terminals without braille."""


def envelope(values: Array, n_column: int) -> tuple[Array, Array]:
    """Lowest and highest value of each of `n_column` parts of a series, shape (n_column,).

    Missing values are ignored; a part without other values is NaN. The parts join without gaps.
    """
    if values.size < n_column:
        low = high = values[np.arange(n_column) * values.size // n_column]
    else:
        starts = np.arange(n_column) * values.size // n_column
        low, high = np.fmin.reduceat(values, starts), np.fmax.reduceat(values, starts)
    joined_low, joined_high = low.copy(), high.copy()
    joined_low[1:] = np.where(np.isnan(low[1:]), np.nan, np.fmin(low[1:], high[:-1]))
    joined_high[1:] = np.where(np.isnan(high[1:]), np.nan, np.fmax(high[1:], low[:-1]))
    return joined_low, joined_high


def draw(low: Array, high: Array, span: tuple[float, float], height: int, *, plain: bool) -> list[str]:
    """An area between two curves as lines of text.

    Parameters
    ----------
    low, high : ndarray, shape (2 · width,)
        Each character has two dots side by side; NaN draws nothing.
    span : (float, float)
        Values at the lowest and highest row of dots.
    height : int
        Lines.
    plain : bool
        Whether the terminal shows only ASCII.
    """
    n_row = 4 * height
    rows = np.arange(n_row)[:, None]
    bottom, top = row_of(low, span, n_row), row_of(high, span, n_row)
    dots = ~np.isnan(low) & (rows >= top) & (rows <= bottom)
    return _as_points(dots) if plain else _as_braille(dots)


def row_of(values: Array, span: tuple[float, float], n_row: int) -> NDArray[np.float64]:
    """Row of each value, 0 at the top; values beyond the span lie at its ends."""
    share = (np.nan_to_num(values) - span[0]) / (span[1] - span[0])
    return np.rint((1.0 - np.clip(share, 0.0, 1.0)) * (n_row - 1))


def _as_braille(dots: NDArray[np.bool_]) -> list[str]:
    n_row, n_column = dots.shape
    cells = dots.reshape(n_row // 4, 4, n_column // 2, 2).transpose(0, 2, 1, 3)
    return [
        "".join(chr(0x2800 + bits) if bits else " " for bits in line) for line in (cells * _DOTS).sum((2, 3))
    ]


def _as_points(dots: NDArray[np.bool_]) -> list[str]:
    n_row, n_column = dots.shape
    cells = dots.reshape(n_row // 4, 2, 2, n_column // 2, 2).max((2, 4)).astype(np.intp)
    characters = cells[:, 0] + 2 * cells[:, 1]
    return ["".join(_POINTS[each] for each in line) for line in characters.tolist()]
