"""Bootstrap of detection rates, including the thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.evaluation.threshold import Threshold

N_DRAW = 400


@dataclass(frozen=True, eq=False)
class Redrawn:
    """Number of times that each record is drawn, with replacement.

    Attributes
    ----------
    healthy : ndarray of int, shape (n_draw, n_healthy)
        Counts of fit records.
    faulty : ndarray of int, shape (n_draw, n_faulty)
        Counts of test records, stratified by severity.
    """

    healthy: NDArray[np.int64]
    faulty: NDArray[np.int64]

    def detected(self, threshold: Threshold, healthy: ArrayLike, faulty: ArrayLike) -> Array:
        """Fraction of faulty records detected in each resample, with a threshold of the same rank.

        Parameters
        ----------
        threshold : Threshold
            Threshold that is an order statistic of the healthy records.
        healthy, faulty : array_like, shape (n_record,)
            Scores of fit and of test records; NaN if there is none, which raises no alarm.

        Returns
        -------
        ndarray, shape (n_draw,)

        Raises
        ------
        NotStatedError
            The threshold comes from a tail model, or no faulty record has a score.
        """
        fit, tested = np.asarray(healthy, dtype=float), np.asarray(faulty, dtype=float)
        if np.isnan(tested).all():
            raise NotStatedError("no faulty record has a score")
        high = self._limit(fit, threshold.high)
        low = -self._limit(-fit, -threshold.low)
        is_alarm = (tested > high[:, None]) | (tested < low[:, None])
        return np.asarray(np.sum(self.faulty * is_alarm, axis=1) / self.faulty.sum(axis=1))

    def _limit(self, healthy: Array, limit: float) -> Array:
        """Upper limits of the same rank, shape (n_draw,)."""
        if np.isinf(limit):
            return np.full(len(self.healthy), limit)
        rank = int(np.sum(healthy >= limit))
        if not np.any(healthy == limit):
            raise NotStatedError("thresholds of a tail model cannot be resampled")
        order = np.argsort(-healthy)[: int(np.sum(~np.isnan(healthy)))]
        reached = np.cumsum(self.healthy[:, order], axis=1) >= rank
        return np.asarray(healthy[order][reached.argmax(axis=1)])


@lru_cache(maxsize=4)
def redrawn(n_healthy: int, n_faulty: tuple[int, ...], seed: int = 0) -> Redrawn:
    """Resample fit records, and test records of each severity; reproducible for the same numbers."""
    draw = np.random.default_rng(seed)
    parts = [draw.multinomial(n, np.full(n, 1.0 / n), size=N_DRAW) for n in (n_healthy, *n_faulty)]
    return Redrawn(parts[0], np.hstack(parts[1:]))
