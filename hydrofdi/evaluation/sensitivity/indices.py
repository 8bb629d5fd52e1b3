"""Sobol indices of a noisy score."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.sensitivity.estimate import Estimate

FEWEST = 16
"""Base points, each with the scores of all of its records."""


@dataclass(frozen=True)
class SobolIndices:
    """Shares of the variance of a score.

    Attributes
    ----------
    first_order : tuple of Estimate, length n_factor
        Of each factor by itself.
    total : tuple of Estimate, length n_factor
        With its interactions with the other factors; those with the noise left out.
    noise : Estimate
        Of what differs when the same plant is recorded again, with its interactions.
    n_lost : int
        Number of base points left out because a score is missing.
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
    """First-order and total indices if every record has its own noise.

    The estimators are those of `scipy.stats.sobol_indices`: Saltelli et al., Computer Physics Communications
    181 (2010) 259, table 2 (b) and (f). Two records of one plant differ by their noise as well, so (f) by
    itself holds the share of the noise for every factor; it is subtracted, as seen between the records of
    the first matrix and those of the same plants again. The variance is that of the scores, noise included:
    without interactions the first-order indices and the noise sum to 1. Intervals by drawing base points.

    Parameters
    ----------
    first, second : array_like, shape (n_base,)
        Scores at the rows of the matrices A and B; NaN if there is none.
    exchanged : array_like, shape (n_factor, n_base)
        At the rows of A with one column from B.
    again : array_like, shape (n_base,)
        At the rows of A, with new noise.
    confidence : float
    n_draw, seed : int
        Of the bootstrap.

    Raises
    ------
    NotStatedError
        Fewer than 16 base points have all of their scores, or these are all equal.
    """
    records = np.vstack((first, second, again, exchanged)).astype(float)
    scores = records[:, np.isfinite(records).all(axis=0)]
    n_base = scores.shape[1]
    if n_base < FEWEST:
        raise NotStatedError(
            f"Sobol indices need {FEWEST} base points with all of their scores, not {n_base}", FEWEST
        )
    if not np.ptp(scores[:2]):
        raise NotStatedError("the score is the same in all records: there is nothing to share out")
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
    """How often each base point is drawn, by their number, shape (n_draw, n_base)."""
    draw = np.random.default_rng(seed)
    return np.asarray(draw.multinomial(n_base, np.full(n_base, 1.0 / n_base), size=n_draw) / n_base)


def _shares(scores: Array, weights: Array) -> Array:
    """First-order and total indices, and the share of the noise, with weighted base points.

    Parameters
    ----------
    scores : ndarray, shape (3 + n_factor, n_base)
        At A, at B, at A again, and at A with each column from B.
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
