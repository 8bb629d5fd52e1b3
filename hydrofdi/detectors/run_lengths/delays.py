"""Time from the onset of a leak to the first alarm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.detectors.charts.contract import Chart
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.scores import Array, share_between_0_and_1


@dataclass(frozen=True)
class Delay:
    """A quantile of detection delays, with its interval [s]; infinite if too many leaks are not detected."""

    value: float
    low: float
    high: float
    confidence: float


@dataclass(frozen=True, eq=False)
class Delays:
    """Detection delay of the leak in each stream.

    Attributes
    ----------
    values : ndarray, shape (n_stream,)
        Time from the onset to the first alarm at or after it [s]; infinite if there is none.
    n_early : ndarray of int, shape (n_stream,)
        Number of alarms before the onset: false alarms, not detections. The chart restarts after each.
    not_measurable : int
        Number of streams without a score after the onset; they count as not detected.
    """

    values: Array
    n_early: np.ndarray
    not_measurable: int

    @property
    def found(self) -> Rate:
        """Fraction of leaks that are detected before their record ends."""
        return alarm_rate(np.isfinite(self.values).astype(float))

    def quantile(self, share: float = 0.5, *, confidence: float = 0.95) -> Delay:
        """Delay within which a given share of the leaks is detected.

        Its distribution-free interval is that of order statistics: David and Nagaraja, Order Statistics
        (2003), section 7.1.

        Parameters
        ----------
        share : float
        confidence : float
        """
        share_between_0_and_1("the share of leaks", share)
        ordered = np.sort(self.values)
        return Delay(_at_rank(ordered, share), *_order_statistics(ordered, share, confidence), confidence)


def delays(
    chart: Chart[Any],
    limit: float,
    streams: ArrayLike,
    instants: ArrayLike,
    onset: ArrayLike,
) -> Delays:
    """Detection delays of a chart that runs from the start of each stream.

    Parameters
    ----------
    chart : Chart
    limit : float
    streams : array_like, shape (n_stream, n_time)
        Standardised scores [-].
    instants : array_like, shape (n_time,)
        Instants of the scores [s].
    onset : array_like, scalar or shape (n_stream,)
        Onset of the leak [s].
    """
    scores, times = np.asarray(streams, dtype=float), np.asarray(instants, dtype=float)
    sets_in = np.broadcast_to(np.asarray(onset, dtype=float), scores.shape[:1])[:, None]
    is_alarm, is_later = chart.follow(scores, limit) >= limit, times >= sets_in
    first = np.where(is_alarm & is_later, times, math.inf).min(axis=1, initial=math.inf)
    unscored = int((~(is_later & ~np.isnan(scores)).any(axis=1)).sum())
    early = np.sum(is_alarm & ~is_later, axis=1)
    return Delays(first - sets_in[:, 0], early, unscored)


def _at_rank(ordered: Array, share: float) -> float:
    return float(ordered[max(math.ceil(share * ordered.size - 1e-9), 1) - 1]) if ordered.size else math.nan


def _order_statistics(ordered: Array, share: float, confidence: float) -> tuple[float, float]:
    from scipy.special import bdtr

    ranks, each = np.arange(ordered.size + 1), (1.0 - confidence) / 2.0
    below = bdtr(ranks, ordered.size, share)
    lower = int(np.sum(below <= each))
    upper = int(np.sum(below < 1.0 - each)) + 1
    low = float(ordered[lower - 1]) if lower else 0.0
    return low, float(ordered[upper - 1]) if upper <= ordered.size else math.inf
