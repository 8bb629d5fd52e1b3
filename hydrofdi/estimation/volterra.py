"""Nonlinear autoregressive model with exogenous input (NARX): a truncated Volterra series with feedback.

Each sample of the signal is a polynomial in past values of signal and input. Leontaritis and Billings,
Input-output parametric models for non-linear systems, Int. J. Control 41 (1985) 303.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Term = tuple[int, ...]
"""Indices of the lagged values that are multiplied; the empty tuple is the constant term."""


def lagged_values(first: str, n_first: int, second: str, n_second: int) -> tuple[str, ...]:
    """Names of the lagged values, in order: ``u1`` is the input one sample earlier."""
    return tuple(
        f"{name}{lag}" for name, n in ((first, n_first), (second, n_second)) for lag in range(1, n + 1)
    )


def polynomial_terms(n_value: int, order: int) -> tuple[Term, ...]:
    """All products of up to `order` values, sorted by degree."""
    places = range(n_value)
    return tuple(
        term for degree in range(order + 1) for term in combinations_with_replacement(places, degree)
    )


def block_means(samples: Array, length: int) -> Array:
    """Block means of the samples, shape (n_record, n_time // length)."""
    n_block = samples.shape[1] // length
    blocks = np.ascontiguousarray(samples[:, : n_block * length])
    return np.asarray(blocks.reshape(-1, n_block, length).mean(axis=2))


def regressors(given: Array, signal: Array, n_given: int, n_own: int, terms: tuple[Term, ...]) -> Array:
    """Regressor matrix of one record, shape (n_equation, n_term).

    Parameters
    ----------
    given, signal : ndarray, shape (n_time,)
    n_given, n_own : int
        Number of lags of the input and of the signal.
    terms : tuple of Term
    """
    start = max(n_given, n_own)
    values = [given[start - lag : given.size - lag] for lag in range(1, n_given + 1)]
    values += [signal[start - lag : signal.size - lag] for lag in range(1, n_own + 1)]
    columns = np.ones((signal.size - start, len(terms)))
    for column, term in zip(columns.T, terms, strict=True):
        for place in term:
            column *= values[place]
    return columns


def ridge_regression(columns: Array, target: Array, ridge: float) -> tuple[Array, float]:
    """Coefficients (n_term,) and RMS of the residual; NaN if they are not determined.

    Parameters
    ----------
    columns : ndarray, shape (n_equation, n_term)
    target : ndarray, shape (n_equation,)
    ridge : float
        Weight of the squared coefficients relative to the mean squared residual [-].
    """
    n_equation, n_term = columns.shape
    roots = np.sqrt(ridge * n_equation) * np.eye(n_term)
    if not (np.isfinite(columns).all() and np.isfinite(target).all()):
        return np.full(n_term, np.nan), np.nan
    padded = np.concatenate((columns, roots)), np.concatenate((target, np.zeros(n_term)))
    coefficients, _, rank, _ = np.linalg.lstsq(*padded, rcond=None)
    if rank < n_term:
        return np.full(n_term, np.nan), np.nan
    return coefficients, float(np.sqrt(np.mean((target - columns @ coefficients) ** 2)))
