"""Linear regression with few unknowns, separately for each record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Regression:
    """Least-squares estimates of many records: values (n_record, n_unknown) and the covariance of errors.

    `condition` (n_record,) is that of the equations after columns are scaled to equal norm.
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
    columns: Array,
    target: Array,
    prior_deviations: Array | None = None,
    error: float = 1.0,
    n_reweighting: int = 0,
) -> Regression:
    """Least squares with standard deviations that allow for correlated errors of adjacent instants.

    `columns` (n_record, n_unknown, n_kind, n_instant) has one equation per kind and instant; equations of
    zeros are ignored. With zero-mean normal priors of `prior_deviations` (n_unknown,), infinite if flat, this
    is the maximum a posteriori estimate: it minimises Σ (residual/error)² + Σ (value/prior deviation)². An
    unknown without information keeps its prior.

    In each of `n_reweighting` iterations the weight is 1/(1 + z²)², with z the residual over three robust
    standard deviations: Geman and McClure, Bull. Int. Stat. Inst. 52 (1987) 5.

    The covariance is that of Newey and West, Econometrica 55 (1987) 703, with lag one, plus the remaining
    uncertainty of the priors. It is too large if adjacent errors have opposite signs.
    """
    n_unknown = columns.shape[1]
    known = np.zeros(n_unknown) if prior_deviations is None else np.square(error / prior_deviations)
    weighed = columns
    values, inverse, condition = _solved(columns, weighed, target, known)
    for _ in range(n_reweighting):
        weighed = columns * robust_weights(_left(columns, target, values))[:, None]
        values, inverse, condition = _solved(columns, weighed, target, known)
    scores = np.sum(weighed * _left(columns, target, values)[:, None], axis=2)
    following = scores[:, :, :-1] @ scores[:, :, 1:].transpose(0, 2, 1)
    spread = scores @ scores.transpose(0, 2, 1) + 0.5 * (following + following.transpose(0, 2, 1))
    spread = spread + np.diag(known) * error**2
    return Regression(values, inverse @ spread @ inverse, condition)


def _solved(columns: Array, weighed: Array, target: Array, known: Array) -> tuple[Array, Array, Array]:
    """Estimates, inverse normal matrix, and condition number."""
    n_record, n_unknown = columns.shape[:2]
    rows = columns.reshape(n_record, n_unknown, -1)
    weighed = weighed.reshape(n_record, n_unknown, -1)
    normal: Array = weighed @ rows.transpose(0, 2, 1) + np.diag(known)
    size = np.sqrt(np.diagonal(normal, axis1=1, axis2=2))
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / size[:, :, None] / size[:, None, :]
    # `eigh` refuses what is not finite: such a record takes the identity, and becomes NaN below.
    is_known = np.asarray(np.isfinite(normal).all(axis=(1, 2)))
    lengths, directions = np.linalg.eigh(np.where(is_known[:, None, None], normal, np.eye(n_unknown)))
    lengths = np.where(is_known[:, None], np.maximum(lengths, 0.0), np.nan)
    inverse = (directions / lengths[:, None, :]) @ directions.transpose(0, 2, 1)
    inverse = inverse / size[:, :, None] / size[:, None, :]
    values = times(inverse, times(weighed, target.reshape(n_record, -1)))
    return values, inverse, np.sqrt(lengths[:, -1] / lengths[:, 0])


def _left(columns: Array, target: Array, values: Array) -> Array:
    left: Array = target - np.sum(columns * values[:, :, None, None], axis=1)
    return left


def robust_weights(left: Array) -> Array:
    """Weight of each equation; zero residuals do not count in the median."""
    size = np.abs(left).reshape(len(left), -1)
    with np.errstate(all="ignore"):
        middle = np.array(
            [np.median(np.extract(row > 0.0, row)) if np.any(row > 0.0) else 1.0 for row in size]
        )
        weights: Array = 1.0 / np.square(1.0 + np.square(left / (3.0 * 1.4826 * middle[:, None, None])))
    return weights


def times(matrices: Array, vectors: Array) -> Array:
    """Product of each matrix (n, k, l) and vector (n, l)."""
    product: Array = np.matmul(matrices, vectors[:, :, None])[:, :, 0]
    return product
