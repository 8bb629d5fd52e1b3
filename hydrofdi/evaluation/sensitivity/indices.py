"""Sobol indices of a noisy score."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.sensitivity.estimate import Estimate

FEWEST = 16
"""Minimum number of base points with all scores."""


@dataclass(frozen=True)
class SobolIndices:
    """Sobol indices: fractions of the variance of a score.

    Attributes
    ----------
    first_order : tuple of Estimate, length n_factor
        First-order index of each factor.
    total : tuple of Estimate, length n_factor
        Total index of each factor: with its interactions with other factors, but not with the noise.
    noise : Estimate
        Fraction from noise between repeated records of the same plant, with its interactions.
    n_lost : int
        Number of base points excluded because a score is missing.
    """

    first_order: tuple[Estimate, ...]
    total: tuple[Estimate, ...]
    noise: Estimate
    n_lost: int


def sobol_indices(
    first: ArrayLike,
    second: ArrayLike,
    exchanged: ArrayLike,
    again: ArrayLike,
    *,
    confidence: float = 0.95,
    n_draw: int = 1000,
    seed: int = 0,
) -> SobolIndices:
    """First-order and total Sobol indices with independent noise in every record.

    The estimators are those of `scipy.stats.sobol_indices`: Saltelli et al., Computer Physics Communications
    181 (2010) 259, table 2 (b) and (f). Two records of one plant also differ by their noise, so (f) includes
    the noise fraction for every factor. It is subtracted, as estimated from the repeated records of the first
    matrix. The variance is that of the scores including noise: without interactions, first-order indices and
    noise sum to 1. Intervals are from a bootstrap of base points.

    Parameters
    ----------
    first, second : array_like, shape (n_base,)
        Scores at the rows of the matrices A and B; NaN if there is no score.
    exchanged : array_like, shape (n_factor, n_base)
        Scores at the rows of A with one column from B.
    again : array_like, shape (n_base,)
        Scores at the rows of A, with new noise.
    confidence : float
    n_draw, seed : int
        Resamples and seed of the bootstrap.

    Raises
    ------
    NotStatedError
        Fewer than 16 base points have all scores, or all scores are equal.
    """
    records = np.vstack((first, second, again, exchanged)).astype(float)
    scores = records[:, np.isfinite(records).all(axis=0)]
    n_base = scores.shape[1]
    if n_base < FEWEST:
        raise NotStatedError(f"Sobol indices need {FEWEST} base points with all scores, not {n_base}", FEWEST)
    if not np.ptp(scores[:2]):
        raise NotStatedError("the score is the same in all records, so it has no variance to explain")
    shares = _shares(scores, np.full((1, n_base), 1.0 / n_base))[:, 0]
    drawn = _shares(scores, _drawn_weights(n_base, n_draw, seed))
    estimates = [Estimate.of(*pair, confidence, n_base) for pair in zip(shares, drawn, strict=True)]
    n_factor = len(scores) - 3
    return SobolIndices(
        tuple(estimates[:n_factor]),
        tuple(estimates[n_factor:-1]),
        estimates[-1],
        records.shape[1] - n_base,
    )


@lru_cache(maxsize=4)
def _drawn_weights(n_base: int, n_draw: int, seed: int) -> Array:
    """Bootstrap weights of the base points, shape (n_draw, n_base); each row sums to 1."""
    draw = np.random.default_rng(seed)
    return np.asarray(draw.multinomial(n_base, np.full(n_base, 1.0 / n_base), size=n_draw) / n_base)


def _shares(scores: Array, weights: Array) -> Array:
    """First-order and total indices, and noise fraction, with weighted base points.

    Parameters
    ----------
    scores : ndarray, shape (3 + n_factor, n_base)
        Scores at A, at B, at A repeated, and at A with each column from B.
    weights : ndarray, shape (n_draw, n_base)
        Each row sums to 1.

    Returns
    -------
    ndarray, shape (2 * n_factor + 1, n_draw)
    """
    centred = scores - scores[:2].mean()
    (a, b, again), pages = centred[:3], centred[3:]
    noise = 0.5 * (a - again) ** 2
    products = np.vstack((b * (pages - a), 0.5 * (a - pages) ** 2 - noise, noise))
    mean, square = np.stack((0.5 * (a + b), 0.5 * (a**2 + b**2))) @ weights.T
    shares: Array = products @ weights.T / (square - mean**2)
    return shares
