"""Sensitivity of scores to nuisances: their spread, and the fault that would do the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, measurable

INNER = (0.05, 0.95)
"""Probabilities of the limits of the inner 90 % range."""

BEYOND = 2.5
"""Minimum expected number of records beyond a quantile; with fewer, nominal 95 % intervals have less than 90
% coverage."""

N_DRAW = 1000


@dataclass(frozen=True)
class Spread:
    """A relative spread of scores with its two-sided interval, from `n_record` records."""

    value: float
    low: float
    high: float
    n_record: int


def relative_spread(
    alone: ArrayLike, together: ArrayLike, *, confidence: float = 0.95, seed: int = 0
) -> Spread:
    """Inner 90 % range of a score with one nuisance, relative to the range with all nuisances.

    Parameters
    ----------
    alone, together : array_like, shape (n_record,)
        Scores of healthy records in which one nuisance varies, or all vary; NaN if a record has no score.
    seed : int
        Seed of the draws for the interval.
    """
    draw = np.random.default_rng(seed)
    scores = np.asarray(alone, dtype=float)
    one, one_drawn = quantiles_and_draws(scores, INNER, draw)
    every, every_drawn = quantiles_and_draws(np.asarray(together, dtype=float), INNER, draw)
    width, widths = float(np.ptp(every)), np.ptp(every_drawn, axis=1)
    if not widths.all() or not width:
        raise NotStatedError("the score is the same in nine healthy records of ten: it has no spread")
    n_record = int(np.isfinite(scores).sum())
    tails = [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0]
    low, high = np.quantile(np.ptp(one_drawn, axis=1) / widths, tails)
    return Spread(float(np.ptp(one) / width), float(low), float(high), n_record)


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

    Returns
    -------
    quantiles : ndarray, shape (n_probability,)
    draws : ndarray, shape (N_DRAW, n_probability)
    """
    known, _ = measurable(scores)
    ordered = np.sort(known[np.isfinite(known)])
    rarest = min(probabilities[0], 1.0 - probabilities[-1])
    needed = math.ceil(BEYOND / rarest - 1.0 - 1e-9)
    if ordered.size < needed:
        kind = "range" if len(probabilities) > 1 else "median"
        raise NotStatedError(f"a {kind} of scores needs {needed} records, not {ordered.size}", needed)
    n_space = ordered.size + 1
    # Spacings of the probabilities are the parameters of the distribution; they need not be whole.
    distances = n_space * np.diff([0.0, *probabilities, 1.0])
    places = np.cumsum(generator.dirichlet(distances, N_DRAW), axis=1)[:, :-1]
    # Expected probabilities of the order statistics.
    at = np.arange(1, n_space) / n_space
    return np.interp(probabilities, at, ordered), np.interp(places, at, ordered)


@dataclass(frozen=True)
class EquivalentFault:
    """Severity of a fault with the same effect on a score; never extrapolated.

    Attributes
    ----------
    severity : float
        The severity, or the smallest or largest tested one [unit of the severity].
    low, high : float
        Interval; 0 if it extends below the tested severities, infinite if above.
    """

    place: Literal["below", "within", "above"]
    severity: float
    low: float
    high: float


class Response:
    """Monotone response of the median score to the severity of a fault.

    Medians are relative to the healthy median, with the sign of the severest fault, and made monotone by
    isotonic regression (Ayer et al., Annals of Mathematical Statistics 26 (1955) 641).

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
        Scores; NaN if a record has none.
    faulty : sequence of array_like
        Scores of each severity.
    severity : array_like, shape (n_level,)
        Above zero, ascending [unit of the severity].
    confidence : float
        Confidence level of all intervals.
    seed : int
        Seed of the draws for the intervals.
    """

    def __init__(
        self,
        healthy: ArrayLike,
        faulty: Sequence[ArrayLike],
        severity: ArrayLike,
        *,
        confidence: float = 0.95,
        seed: int = 0,
    ) -> None:
        if len(faulty) < 2:
            raise NotStatedError("an equivalent fault needs at least two tested severities")
        self.severity, self.confidence = np.asarray(severity, dtype=float), confidence
        self._draw = np.random.default_rng(seed)
        medians, drawn = self._medians([healthy, *faulty])
        shifts, drawn_shifts = medians[1:] - medians[0], drawn[:, 1:] - drawn[:, :1]
        ends = np.quantile(drawn_shifts[:, -1], [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
        if ends[0] <= 0.0 <= ends[1]:
            raise NotStatedError("the severest fault does not change the median of the score")
        self.sign = float(np.sign(shifts[-1]))
        self._shifts = rising(self.sign * shifts[None])
        self._drawn = rising(self.sign * drawn_shifts)

    def reach(self, scores: ArrayLike, centre: ArrayLike) -> tuple[EquivalentFault, EquivalentFault]:
        """Faults whose effect at least one healthy record in twenty imitates, and hides.

        A hidden one is compensated: the score returns to the centre.

        Parameters
        ----------
        scores : array_like, shape (n_record,)
            Scores of healthy records with the nuisance.
        centre : array_like, shape (n_record,)
            Scores of healthy records without the nuisance; their median is the centre.
        """
        middle, middles = self._medians([centre])
        directed = self.sign * np.asarray(scores, dtype=float)
        ends, drawn = quantiles_and_draws(directed, INNER, self._draw)
        outer, outers = ends - self.sign * middle, drawn - self.sign * middles
        imitated = self._equivalent(float(outer[1]), outers[:, 1])
        return imitated, self._equivalent(float(-outer[0]), -outers[:, 0])

    def _medians(self, samples: Sequence[ArrayLike]) -> tuple[Array, Array]:
        pairs = [
            quantiles_and_draws(np.asarray(scores, dtype=float), [0.5], self._draw) for scores in samples
        ]
        return np.concatenate([value for value, _ in pairs]), np.hstack([drawn for _, drawn in pairs])

    def _equivalent(self, shift: float, drawn: Array) -> EquivalentFault:
        severity = float(_inverse(self._shifts, np.array([shift]), self.severity)[0])
        draws = _inverse(self._drawn, drawn, self.severity)
        tails = [(1.0 - self.confidence) / 2.0, (1.0 + self.confidence) / 2.0]
        low, high = np.quantile(draws, tails, method="closest_observation").tolist()
        if severity == 0.0:
            return EquivalentFault("below", float(self.severity[0]), low, high)
        if np.isinf(severity):
            return EquivalentFault("above", float(self.severity[-1]), low, high)
        return EquivalentFault("within", severity, low, high)


def rising(rows: Array) -> Array:
    """Isotonic regression of each row, shape (n, n_level).

    Value k is the maximum over i ≤ k of the minimum over j ≥ k of the means from i to j: Robertson, Wright
    and Dykstra, Order Restricted Statistical Inference (1988), section 1.4.
    """
    n_level = rows.shape[1]
    # The mean of any stretch is a difference of two sums over its length.
    sums = np.cumsum(np.insert(rows, 0, 0.0, axis=1), axis=1)
    best = np.full(rows.shape, -np.inf)
    for first in range(n_level):
        means = (sums[:, first + 1 :] - sums[:, first : first + 1]) / np.arange(1, n_level - first + 1)
        # Accumulated from the end: the minimum over all later ends of the stretch.
        least = np.minimum.accumulate(means[:, ::-1], axis=1)[:, ::-1]
        best[:, first:] = np.maximum(best[:, first:], least)
    return best


def _inverse(shifts: Array, asked: Array, severity: Array) -> Array:
    """Severity of a given shift, interpolated logarithmically between the tested severities.

    Parameters
    ----------
    shifts : ndarray, shape (n, n_level)
        Nondecreasing along the last axis.
    asked : ndarray, shape (n,)
    severity : ndarray, shape (n_level,)

    Returns
    -------
    ndarray, shape (n,)
        0 below the tested severities, infinite above.
    """
    is_reached = shifts >= asked[:, None]
    place = np.where(is_reached.any(axis=1), is_reached.argmax(axis=1), len(severity))
    after = np.clip(place, 1, len(severity) - 1)
    rows = np.arange(len(shifts))
    low, high = shifts[rows, after - 1], shifts[rows, after]
    # Neighbours are equal only where the result is not used.
    share = np.clip((asked - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0)
    logarithm = np.log(severity)
    inside = np.exp(logarithm[after - 1] + share * (logarithm[after] - logarithm[after - 1]))
    return np.where(place == 0, 0.0, np.where(place == len(severity), np.inf, inside))
