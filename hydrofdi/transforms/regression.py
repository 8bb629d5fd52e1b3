"""Linear regressions with few unknowns, one for each record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Regression:
    """Least squares of many records.

    Attributes
    ----------
    values, deviations : ndarray, shape (n_record, n_unknown)
        Estimates and their standard deviations.
    condition : ndarray, shape (n_record,)
        Condition number of the equations with columns of equal length.
    """

    values: Array
    deviations: Array
    condition: Array


def regress(columns: Array, target: Array) -> Regression:
    """Least squares; deviations allow for errors that go along from one instant to its neighbours.

    Parameters
    ----------
    columns : ndarray, shape (n_record, n_unknown, n_kind, n_instant)
        Equations of some kinds at each instant.
    target : ndarray, shape (n_record, n_kind, n_instant)

    Notes
    -----
    The deviations are those of Newey and West, Econometrica 55 (1987) 703, with one neighbour. They are too
    large where the errors of neighbours have opposite signs.
    """
    n_record, n_unknown = columns.shape[:2]
    size = np.sqrt(np.sum(np.square(columns), axis=(2, 3)))
    scaled = columns / size[:, :, None, None]
    rows = scaled.reshape(n_record, n_unknown, -1)
    normal = rows @ rows.transpose(0, 2, 1)
    is_known = np.isfinite(normal).all(axis=(1, 2))
    lengths, directions = np.linalg.eigh(np.where(is_known[:, None, None], normal, np.eye(n_unknown)))
    lengths = np.where(is_known[:, None], np.maximum(lengths, 0.0), np.nan)
    inverse = (directions / lengths[:, None, :]) @ directions.transpose(0, 2, 1)
    flat = target.reshape(n_record, -1)
    values = _times(inverse, _times(rows, flat))
    left = (flat - np.sum(rows * values[:, :, None], axis=1)).reshape(target.shape)
    scores = np.sum(scaled * left[:, None], axis=2)
    following = scores[:, :, :-1] @ scores[:, :, 1:].transpose(0, 2, 1)
    spread = scores @ scores.transpose(0, 2, 1) + 0.5 * (following + following.transpose(0, 2, 1))
    variance = np.diagonal(inverse @ spread @ inverse, axis1=1, axis2=2)
    condition = np.sqrt(lengths[:, -1] / lengths[:, 0])
    return Regression(values / size, np.sqrt(np.maximum(variance, 0.0)) / size, condition)


def _times(matrices: Array, vectors: Array) -> Array:
    product: Array = np.matmul(matrices, vectors[:, :, None])[:, :, 0]
    return product
