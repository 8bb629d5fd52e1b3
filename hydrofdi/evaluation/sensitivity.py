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
    """

    place: Literal["below", "within", "above"]
    severity: float


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
        Confidence with which the severest fault must change the median.
    """

    def __init__(
        self,
        healthy: ArrayLike,
        faulty: Sequence[ArrayLike],
        severity: ArrayLike,
        *,
        confidence: float = 0.95,
    ) -> None:
        from scipy.optimize import isotonic_regression

        if len(faulty) < 2:
            raise NotStatedError("an equivalent fault needs at least two tested severities")
        draw = np.random.default_rng(0)
        found = [quantiles_and_draws(np.asarray(own, dtype=float), [0.5], draw) for own in (healthy, *faulty)]
        shifts = np.array([float(median[0]) for median, _ in found])[1:] - found[0][0]
        drawn = found[-1][1] - found[0][1]
        ends = np.quantile(drawn, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
        if ends[0] <= 0.0 <= ends[1]:
            raise NotStatedError("the severest fault does not change the median of the score")
        self.severity, self.sign = np.asarray(severity, dtype=float), float(np.sign(shifts[-1]))
        self._shifts = np.asarray(isotonic_regression(self.sign * shifts).x)

    def imitated(self, scores: ArrayLike, centre: ArrayLike) -> EquivalentFault:
        """Fault whose effect at least one healthy record in twenty imitates.

        Parameters
        ----------
        scores : array_like, shape (n_record,)
            Scores of healthy records with the nuisance.
        centre : array_like, shape (n_record,)
            Scores of healthy records without the nuisance; their median is the centre.
        """
        draw, directed = np.random.default_rng(0), self.sign * np.asarray(scores, dtype=float)
        (middle,), _ = quantiles_and_draws(np.asarray(centre, dtype=float), [0.5], draw)
        shift = float(quantiles_and_draws(directed, INNER, draw)[0][1] - self.sign * middle)
        if shift <= self._shifts[0]:
            return EquivalentFault("below", float(self.severity[0]))
        if shift > self._shifts[-1]:
            return EquivalentFault("above", float(self.severity[-1]))
        logarithm = np.interp(shift, self._shifts, np.log(self.severity))
        return EquivalentFault("within", float(np.exp(logarithm)))
