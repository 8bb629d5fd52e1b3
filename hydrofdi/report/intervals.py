"""Ranges of numbers, and shares of draws with their confidence intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Z_95 = 1.959963984540054
"""Quantile of the normal distribution for a two-sided confidence of 95 %."""


@dataclass(frozen=True)
class Share:
    """A share of draws, with its 95 % confidence interval; NaN if there are no draws.

    Attributes
    ----------
    count, total : int
    low, high : float
        Ends of the interval [-].
    """

    count: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The share [-]."""
        return self.count / self.total if self.total else math.nan


def wilson_interval(share: float, n: float, z: float = Z_95) -> tuple[float, float]:
    """Score interval of a share of `n` independent draws.

    Wilson, Journal of the American Statistical Association 22 (1927) 209.

    Parameters
    ----------
    share : float
        0 … 1.
    n : float
        Number of draws, or their effective number.
    z : float
        Quantile of the normal distribution for the confidence.
    """
    centre = share + z * z / (2.0 * n)
    spread = z * math.sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n))
    scale = 1.0 + z * z / n
    return max(0.0, (centre - spread) / scale), min(1.0, (centre + spread) / scale)


def clustered_share(outcomes: NDArray[np.bool_], clusters: Sequence[int] | NDArray[np.int64]) -> Share:
    """The share of true outcomes; those of one cluster depend on each other.

    The interval is Wilson's for the effective number of draws: the number of independent ones that would
    give the share the variance that it has between clusters, at most the number of outcomes. Where all
    clusters agree it is the number of clusters. After Rao and Scott, Biometrics 48 (1992) 577.

    Parameters
    ----------
    outcomes : ndarray of bool, shape (n,)
    clusters : sequence of int, shape (n,)
        Equal for draws that depend on each other.
    """
    total = int(outcomes.size)
    if not total:
        return Share(0, 0, math.nan, math.nan)
    count = int(outcomes.sum())
    low, high = wilson_interval(count / total, _effective_number(outcomes, clusters))
    return Share(count, total, low, high)


def _effective_number(outcomes: NDArray[np.bool_], clusters: Sequence[int] | NDArray[np.int64]) -> float:
    _, places = np.unique(np.asarray(clusters), return_inverse=True)
    hits, sizes = np.bincount(places, outcomes), np.bincount(places)
    n_cluster, total, share = hits.size, outcomes.size, float(outcomes.mean())
    if n_cluster == 1:
        return 1.0
    variance = n_cluster / (n_cluster - 1) * float(np.sum((hits - share * sizes) ** 2)) / total**2
    if variance == 0.0:
        return float(n_cluster)
    return min(float(total), share * (1.0 - share) / variance)


def span_of(values: Iterable[float]) -> tuple[float, float]:
    """Smallest and largest of some numbers, without NaN; NaN if there is none."""
    known = [float(value) for value in values if not math.isnan(value)]
    return min(known, default=math.nan), max(known, default=math.nan)
