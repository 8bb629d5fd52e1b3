"""Mean run lengths and limits for independent normal scores of unit variance.

Scores over time are dependent, so these do not apply to them: use `FalseAlarms` for their limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.scores import Array

N_NODE = 48
"""Number of Gauss-Legendre nodes: gives eight digits, and is small enough for single-threaded BLAS."""


def cusum_run_length(
    limit: float, *, shift: float = 1.0, mean: float = 0.0, direction: Direction = Direction.BOTH
) -> float:
    """Mean number of scores until a CUSUM of independent normal scores reaches its limit.

    Page's integral equation, N(s) = 1 + N(0) Φ(k − s) + ∫₀ʰ N(y) φ(y + k − s) dy, solved at Gauss-Legendre
    nodes. Two-sided: 1/N = 1/N⁺ + 1/N⁻ (Kemp, Journal of the Royal Statistical Society B 23 (1961) 149).

    Parameters
    ----------
    limit : float
        h [standard deviations].
    shift : float
        Twice k [standard deviations].
    mean : float
        Mean of the scores [standard deviations].
    direction : Direction
    """
    return _of_sides(lambda side: _one_sided_cusum(limit, shift / 2.0, side * mean), direction)


def siegmund_run_length(
    limit: float, *, shift: float = 1.0, mean: float = 0.0, direction: Direction = Direction.BOTH
) -> float:
    """Siegmund's approximation of `cusum_run_length`.

    (exp(−2Δb) + 2Δb − 1)/(2Δ²), Δ = mean − k, b = h + 1.166: Siegmund, Sequential Analysis (1985), section 2.

    Parameters
    ----------
    limit, shift, mean, direction
        See `cusum_run_length`.
    """
    height = limit + 1.166

    def one_sided(side: float) -> float:
        drift = side * mean - shift / 2.0
        if abs(drift) < 1e-9:
            return height**2
        return (math.exp(-2.0 * drift * height) + 2.0 * drift * height - 1.0) / (2.0 * drift**2)

    return _of_sides(one_sided, direction)


def ewma_run_length(
    limit: float, *, weight: float = 0.1, mean: float = 0.0, direction: Direction = Direction.BOTH
) -> float:
    """Mean number of scores until an EWMA with limiting variance alarms, for independent normal scores.

    Crowder's integral equation, N(z) = 1 + (1/λ) ∫ N(y) φ((y − (1 − λ) z)/λ − mean) dy: Technometrics 29
    (1987) 401. For one direction, the second limit is ten standard deviations away, so it is not reached.

    Parameters
    ----------
    limit : float
        L, in limiting standard deviations of the average.
    weight : float
        λ.
    mean : float
        Mean of the scores [standard deviations].
    direction : Direction
    """
    sign = -1.0 if direction is Direction.FALLING else 1.0
    width = limit * math.sqrt(weight / (2.0 - weight))
    far = 10.0 * math.sqrt(weight / (2.0 - weight)) + abs(mean)
    lowest = -width if direction is Direction.BOTH else -far
    nodes, weights = _gauss_legendre(lowest, width)

    def kernel(start: Array | float) -> Array:
        deviation = (nodes - (1.0 - weight) * np.asarray(start)[..., None]) / weight - sign * mean
        return weights * _density(deviation) / weight

    lengths = np.linalg.solve(np.eye(nodes.size) - kernel(nodes), np.ones(nodes.size))
    return float(1.0 + kernel(0.0) @ lengths)


def limit_for(run_length: float, of_limit: Callable[[float], float], *, most: float = 100.0) -> float:
    """Limit with a required mean run length.

    Parameters
    ----------
    run_length : float
        Required mean number of scores until a false alarm.
    of_limit : callable
        Mean run length as an increasing function of the limit, such as `cusum_run_length`.
    most : float
        Largest limit of the search.

    Raises
    ------
    ValueError
        No limit between 0 and `most` has this run length.
    """
    least, high = 1e-9, 1.0
    while high < most and of_limit(high) < run_length:
        high = min(1.2 * high, most)
    if not of_limit(least) <= run_length <= of_limit(high):
        raise ValueError(f"no limit up to {most:g} has a mean run length of {run_length:g}")
    from scipy.optimize import brentq

    return float(brentq(lambda limit: math.log(of_limit(limit) / run_length), least, high, xtol=1e-10))


def _of_sides(one_sided: Callable[[float], float], direction: Direction) -> float:
    if direction is Direction.BOTH:
        return 1.0 / (1.0 / one_sided(1.0) + 1.0 / one_sided(-1.0))
    return one_sided(1.0 if direction is Direction.RISING else -1.0)


def _one_sided_cusum(limit: float, reference: float, mean: float) -> float:
    from scipy.special import ndtr

    nodes, weights = _gauss_legendre(0.0, limit)
    starts = np.concatenate(([0.0], nodes))
    system = np.eye(starts.size)
    system[:, 0] -= ndtr(reference - mean - starts)
    system[:, 1:] -= weights * _density(nodes + reference - mean - starts[:, None])
    return float(np.linalg.solve(system, np.ones(starts.size))[0])


def _gauss_legendre(low: float, high: float) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(N_NODE)
    half = (high - low) / 2.0
    return low + half * (nodes + 1.0), half * weights


def _density(deviation: Array) -> Array:
    return np.asarray(np.exp(-0.5 * np.square(deviation)) / math.sqrt(2.0 * math.pi))
