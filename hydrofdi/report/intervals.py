"""Shares, ranges and rank correlations with their intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.evaluation.rates import Rate
from hydrofdi.evaluation.scores import comparable

Z_95 = 1.959963984540054
"""Quantile of the normal distribution for a two-sided confidence of 95 %."""


def wilson_interval(share: float, n: float) -> tuple[float, float]:
    """95 % score interval of a share of `n` independent draws.

    Wilson, Journal of the American Statistical Association 22 (1927) 209.
    """
    z = Z_95
    centre = share + z * z / (2.0 * n)
    spread = z * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    scale = 1.0 + z * z / n
    return max(0.0, (centre - spread) / scale), min(1.0, (centre + spread) / scale)


def clustered_share(outcomes: NDArray[np.bool_], clusters: Sequence[int] | NDArray[np.int64]) -> Rate:
    """The share of true outcomes; those of one cluster depend on each other.

    The interval is Wilson's for the effective number of draws: the number of independent ones that would
    give the share the variance that it has between clusters, at most the number of outcomes. Where all
    clusters agree it is the number of clusters. After Rao and Scott, Biometrics 48 (1992) 577.
    """
    total = int(outcomes.size)
    if not total:
        return Rate(0, 0, 0, math.nan, math.nan, 0.95)
    count = int(outcomes.sum())
    low, high = wilson_interval(count / total, _effective_number(outcomes, clusters))
    return Rate(count, total, 0, low, high, 0.95)


def _effective_number(outcomes: NDArray[np.bool_], clusters: Sequence[int] | NDArray[np.int64]) -> float:
    _, places = np.unique(np.asarray(clusters), return_inverse=True)
    hits, sizes = np.bincount(places, outcomes), np.bincount(places)
    n_cluster, total, share = hits.size, outcomes.size, float(outcomes.mean())
    if n_cluster == 1:
        return 1.0
    variance = n_cluster / (n_cluster - 1) * float(np.sum((hits - share * sizes) ** 2)) / total**2
    if variance < 1e-24:
        return float(n_cluster)
    return min(float(total), share * (1.0 - share) / variance)


def span_of(values: Iterable[float]) -> tuple[float, float]:
    """Smallest and largest of some numbers, without NaN; NaN if there is none."""
    known = [float(value) for value in values if not math.isnan(value)]
    return min(known, default=math.nan), max(known, default=math.nan)


Array = NDArray[np.float64]

LEAST_RUNS = 10
"""Smallest number of runs for a rank correlation; below, its interval would not cover."""


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's ρ.

    Attributes
    ----------
    value : float
        −1 … 1; NaN if the feature or the parameter is constant, or if there are too few runs.
    low, high : float
        95 % confidence interval.
    chance : float
        Bound of abs(ρ) in 95 % of cases if the feature does not depend on the parameter.
    n_run : int
        Number of runs used.
    """

    value: float
    low: float
    high: float
    chance: float
    n_run: int


def rank_correlation(parameter: Array, feature: Array) -> RankCorrelation:
    """Spearman's ρ over the runs that have both numbers.

    The standard error follows from the influence of each run on ρ, which assumes no distribution; the
    interval is taken on Fisher's scale, artanh ρ. Without dependence ρ has the variance 1/(n − 1).
    Kendall and Gibbons, Rank Correlation Methods, 5th edition, 1990.
    """
    parameter, feature = comparable(parameter), comparable(feature)
    known = np.isfinite(parameter) & np.isfinite(feature)
    n_run = int(known.sum())
    if n_run < LEAST_RUNS or np.ptp(parameter[known]) == 0.0 or np.ptp(feature[known]) == 0.0:
        return RankCorrelation(math.nan, math.nan, math.nan, math.nan, n_run)
    x, y = _ranks(parameter[known]), _ranks(feature[known])
    value = float(np.clip(np.mean(x * y), -1.0, 1.0))
    error = _standard_error(x, y)
    low, high = _fisher_interval(value, error)
    return RankCorrelation(value, low, high, Z_95 / math.sqrt(n_run - 1), n_run)


def _ranks(values: Array) -> Array:
    """Mean ranks, scaled to mean 0 and variance 1."""
    from scipy.stats import rankdata

    ranks = rankdata(values)
    scaled: Array = (ranks - ranks.mean()) / ranks.std()
    return scaled


def _standard_error(x: Array, y: Array) -> float:
    """From the influence of each run: through its own ranks, and through those of the others."""
    influence = x * y + _moved(x, y) + _moved(y, x)
    return float(np.std(influence, ddof=1)) / math.sqrt(len(x))


def _moved(x: Array, y: Array) -> Array:
    """How a run at each x moves the ranks of all runs above it, weighted with their y; of mean zero."""
    order = np.argsort(x, kind="stable")
    above = np.empty_like(y)
    above[order] = np.cumsum(y[order][::-1])[::-1]
    step = 1.0 / np.std(np.arange(len(x)))
    moved: Array = step * (above - above.mean())
    return moved


def _fisher_interval(value: float, error: float) -> tuple[float, float]:
    """95 % interval on the scale of artanh; a point at a perfect correlation."""
    if abs(value) > 1.0 - 1e-12:
        return value, value
    half = Z_95 * error / (1.0 - value**2)
    centre = math.atanh(value)
    return math.tanh(centre - half), math.tanh(centre + half)
