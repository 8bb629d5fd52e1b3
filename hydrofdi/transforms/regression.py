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
    values : ndarray, shape (n_record, n_unknown)
        Estimates.
    covariance : ndarray, shape (n_record, n_unknown, n_unknown)
        Covariance of their errors.
    condition : ndarray, shape (n_record,)
        Condition number of the equations with columns of equal length.
    """

    values: Array
    covariance: Array
    condition: Array

    def combined(self, factors: Array) -> tuple[Array, Array]:
        """Sum of the unknowns times `factors` (n_unknown,), and its standard deviation; both (n_record,)."""
        variance = np.sum(self.covariance * np.outer(factors, factors), axis=(1, 2))
        total: Array = np.sum(self.values * factors, axis=1)
        return total, np.sqrt(np.maximum(variance, 0.0))


def regress(
    columns: Array, target: Array, prior_deviations: Array | None = None, error: float = 1.0
) -> Regression:
    """Least squares; deviations allow for errors that go along from one instant to its neighbours.

    With normal priors about zero it is the most probable estimate: minimise Σ (left/error)² + Σ (value/prior
    deviation)². An unknown that nothing moves then keeps its prior.

    Parameters
    ----------
    columns : ndarray, shape (n_record, n_unknown, n_kind, n_instant)
        Equations of some kinds at each instant.
    target : ndarray, shape (n_record, n_kind, n_instant)
    prior_deviations : ndarray, shape (n_unknown,), optional
        Standard deviations of the unknowns about zero beforehand; infinite where nothing is known.
    error : float
        Standard deviation of what an equation leaves, which weighs it against the priors.

    Notes
    -----
    The covariance is that of Newey and West, Econometrica 55 (1987) 703, with one neighbour, plus what the
    priors leave open. It is too large where the errors of neighbours have opposite signs.
    """
    n_record, n_unknown = columns.shape[:2]
    known = np.zeros(n_unknown) if prior_deviations is None else np.square(error / prior_deviations)
    rows = columns.reshape(n_record, n_unknown, -1)
    normal = rows @ rows.transpose(0, 2, 1) + np.diag(known)
    size = np.sqrt(np.diagonal(normal, axis1=1, axis2=2))
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / size[:, :, None] / size[:, None, :]
    is_known = np.isfinite(normal).all(axis=(1, 2))
    lengths, directions = np.linalg.eigh(np.where(is_known[:, None, None], normal, np.eye(n_unknown)))
    lengths = np.where(is_known[:, None], np.maximum(lengths, 0.0), np.nan)
    inverse = (directions / lengths[:, None, :]) @ directions.transpose(0, 2, 1)
    inverse = inverse / size[:, :, None] / size[:, None, :]
    flat = target.reshape(n_record, -1)
    values = _times(inverse, _times(rows, flat))
    left = (flat - np.sum(rows * values[:, :, None], axis=1)).reshape(target.shape)
    scores = np.sum(columns * left[:, None], axis=2)
    following = scores[:, :, :-1] @ scores[:, :, 1:].transpose(0, 2, 1)
    spread = scores @ scores.transpose(0, 2, 1) + 0.5 * (following + following.transpose(0, 2, 1))
    spread = spread + np.diag(known) * error**2
    condition = np.sqrt(lengths[:, -1] / lengths[:, 0])
    return Regression(values, inverse @ spread @ inverse, condition)


def _times(matrices: Array, vectors: Array) -> Array:
    product: Array = np.matmul(matrices, vectors[:, :, None])[:, :, 0]
    return product
