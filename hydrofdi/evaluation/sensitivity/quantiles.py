"""Quantiles of scores, and how they would come out in other records of the same population."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable

INNER = (0.05, 0.95)
"""Ends of the range that contains nine scores in ten."""

BEYOND = 2.5
"""Records expected beyond a quantile: with fewer, intervals of 95 % hold less often than 90 %."""

N_DRAW = 1000


def quantiles_and_draws(
    scores: Array, probabilities: Sequence[float], generator: np.random.Generator
) -> tuple[Array, Array]:
    """Quantiles, and draws of them that carry their uncertainty.

    The order statistics of n records lie at probabilities that have Dirichlet-distributed distances, whatever
    the distribution of the scores. Those at p (n + 1), fractional ones included, are drawn and read off the
    scores: Hutson, Journal of Applied Statistics 26 (1999) 343.

    Parameters
    ----------
    scores : ndarray, shape (n_record,)
        NaN if a record has none; infinite ones are not used.
    probabilities : sequence of float
        Ascending, between 0 and 1.
    generator : Generator

    Returns
    -------
    quantiles : ndarray, shape (n_probability,)
    draws : ndarray, shape (N_DRAW, n_probability)

    Raises
    ------
    NotStatedError
        Too few records have a score: 49 for the ends of the inner range, 4 for a median.
    """
    known, _ = measurable(scores)
    ordered = np.sort(known[np.isfinite(known)])
    rarest = min(probabilities[0], 1.0 - probabilities[-1])
    needed = math.ceil(BEYOND / rarest - 1.0 - 1e-9)
    if ordered.size < needed:
        kind = "range" if len(probabilities) > 1 else "median"
        raise NotStatedError(f"a {kind} of scores needs {needed} records, not {ordered.size}", needed)
    n_space = ordered.size + 1
    distances = n_space * np.diff([0.0, *probabilities, 1.0])
    places = np.cumsum(generator.dirichlet(distances, N_DRAW), axis=1)[:, :-1]
    at = np.arange(1, n_space) / n_space
    return np.interp(probabilities, at, ordered), np.interp(places, at, ordered)
