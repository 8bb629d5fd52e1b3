"""Quantiles of scores, and how they would come out in other records of the same population."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable

INNER = (0.05, 0.95)
"""Ends of the range that holds nine scores in ten."""

FEWEST = 19
"""Records from which on the ends of this range lie inside of the scores."""

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
        NaN where a record has none; infinite ones are not used.
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
        Fewer than 19 records have a score.
    """
    known, _ = measurable(scores)
    ordered = np.sort(known[np.isfinite(known)])
    if ordered.size < FEWEST:
        raise NotStatedError(f"a range of scores needs {FEWEST} records, not {ordered.size}", FEWEST)
    n_space = ordered.size + 1
    distances = n_space * np.diff([0.0, *probabilities, 1.0])
    places = np.cumsum(generator.dirichlet(distances, N_DRAW), axis=1)[:, :-1]
    at = np.arange(1, n_space) / n_space
    return np.interp(probabilities, at, ordered), np.interp(places, at, ordered)
