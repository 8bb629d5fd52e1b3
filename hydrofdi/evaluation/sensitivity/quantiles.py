"""Quantiles of scores and their sampling uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable

INNER = (0.05, 0.95)
"""Probabilities of the limits of the inner 90 % range."""

BEYOND = 2.5
"""Minimum expected number of records beyond a quantile; with fewer, nominal 95 % intervals have less than 90
% coverage."""

N_DRAW = 1000


def quantiles_and_draws(
    scores: Array, probabilities: Sequence[float], generator: np.random.Generator
) -> tuple[Array, Array]:
    """Quantiles, and random draws that represent their uncertainty.

    For any distribution of scores, the probabilities of the order statistics of n records have
    Dirichlet-distributed spacings. Order statistics at p (n + 1), including fractional ones, are drawn and
    interpolated in the scores: Hutson, Journal of Applied Statistics 26 (1999) 343.

    Parameters
    ----------
    scores : ndarray, shape (n_record,)
        NaN if a record has no score; infinite scores are not used.
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
        Too few records have a score: the limits of the inner range need 49, a median 4.
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
