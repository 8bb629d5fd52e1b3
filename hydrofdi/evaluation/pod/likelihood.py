"""Likelihood of hits and misses under an increasing curve with a floor, and its maximum."""

from __future__ import annotations

from typing import Literal

import numpy as np

from hydrofdi.evaluation.pod.tally import Tally
from hydrofdi.evaluation.scores import Array

Link = Literal["logit", "probit"]

MOST_STEPS = 100

CERTAIN = 36.0
"""Predictor at which a probability is 1 in double precision; at its negative it is 0."""


def log_cumulative(predictor: Array, link: Link) -> Array:
    """ln F of the logistic or the normal distribution."""
    if link == "logit":
        return np.asarray(-np.logaddexp(0.0, -predictor))
    from scipy.special import log_ndtr

    return np.asarray(log_ndtr(predictor))


def inverse_cumulative(probability: float, link: Link) -> float:
    """F⁻¹, the value of the linear predictor."""
    from scipy.special import logit, ndtri

    return float(logit(probability) if link == "logit" else ndtri(probability))


def log_likelihood(predictor: Array, tally: Tally, floor: float, link: Link) -> float:
    """ln L of P = α + (1 - α) F(predictor), without the binomial coefficients.

    Parameters
    ----------
    predictor : ndarray, shape (n_level,)
    tally : Tally
    floor : float
        α.
    link : str
    """
    log_hit, log_above = _logarithms(predictor, floor, link)
    return float(_times(tally.hits, log_hit) + _times(tally.misses, log_above + np.log1p(-floor)))


def maximise(
    design: Array, offset: Array, tally: Tally, floor: float, link: Link, start: float = 0.0
) -> Array:
    """Maximum-likelihood coefficients β of the predictor offset + design β.

    Fisher scoring with step halving: McCullagh and Nelder, Generalized Linear Models (1989), section 2.5; the
    floor is Abbott's natural response: Finney, Probit Analysis (1971), chapter 7. If hits and misses are
    separated, the coefficients grow until the likelihood no longer increases.

    Parameters
    ----------
    design : ndarray, shape (n_level, n_coefficient)
    offset : ndarray, shape (n_level,)
    tally : Tally
    floor : float
    link : str
    start : float
        Initial value of all coefficients.

    Returns
    -------
    coefficients : ndarray, shape (n_coefficient,)
    """
    coefficients = np.full(design.shape[1], start)
    best = log_likelihood(offset + design @ coefficients, tally, floor, link)
    for _ in range(MOST_STEPS):
        predictor = np.clip(offset + design @ coefficients, -CERTAIN, CERTAIN)
        score, weight = _score(predictor, tally, floor, link)
        information = design.T @ (weight[:, None] * design)
        step = np.linalg.lstsq(information, design.T @ score, rcond=1e-12)[0]
        for halving in 0.5 ** np.arange(30):
            trial = coefficients + halving * step
            value = log_likelihood(offset + design @ trial, tally, floor, link)
            if value >= best:
                break
        else:
            return coefficients
        gain, coefficients, best = value - best, trial, value
        if gain < 1e-9:
            break
    return coefficients


def _logarithms(predictor: Array, floor: float, link: Link) -> tuple[Array, Array]:
    """ln P, and ln F(-predictor) = ln (1 - P) - ln (1 - α)."""
    log_rise = np.log1p(-floor) + log_cumulative(predictor, link)
    log_hit = np.logaddexp(np.log(floor), log_rise) if floor else log_rise
    return log_hit, log_cumulative(-predictor, link)


def _score(predictor: Array, tally: Tally, floor: float, link: Link) -> tuple[Array, Array]:
    """Derivative of ln L by the predictor, and its expected information, for each level."""
    log_hit, log_above = _logarithms(predictor, floor, link)
    if link == "logit":
        log_density = log_cumulative(predictor, link) + log_above
    else:
        log_density = -(predictor**2) / 2.0 - 0.5 * np.log(2.0 * np.pi)
    of_hit = np.exp(np.log1p(-floor) + log_density - log_hit)
    of_miss = np.exp(log_density - log_above)
    return tally.hits * of_hit - tally.misses * of_miss, tally.total * of_hit * of_miss


def _times(counts: Array, logarithms: Array) -> Array:
    """Sum of products in which 0 · -∞ is 0; -∞ on overflow."""
    with np.errstate(over="ignore"):
        return np.asarray(np.sum(counts * np.where(counts > 0.0, logarithms, 0.0)))
