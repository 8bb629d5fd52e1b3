"""Severity: the probability of detection over it, and which of it a nuisance imitates, with bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, Estimate, comparable, measurable


@dataclass(frozen=True)
class DetectableSeverity:
    """A severity within the tested range, or the side of the range; never extrapolated.

    Attributes
    ----------
    place : str
        ``within`` the tested severities, ``below`` them (it is at most the smallest) or ``above`` (not
        detectable up to the largest).
    severity : float
        The severity, or the smallest or largest tested one [unit of the severity].
    probability : float
        Probability of detection.
    confidence : float or None
        Confidence that the severity is not larger; None for the estimate itself.
    source : str
        Source of the value: a fitted ``curve``, or only the tested ``levels``.
    """

    place: Literal["below", "within", "above"]
    severity: float
    probability: float
    confidence: float | None = None
    source: Literal["curve", "levels"] = "curve"

    @property
    def value(self) -> float | None:
        """Severity that is detected with at least this probability; None if no tested severity is."""
        return None if self.place == "above" else self.severity


MOST_SEVERITIES = 1000
"""Maximum number of distinct severities; closer ones are merged."""


@dataclass(frozen=True, eq=False)
class HitCount:
    """Faulty records counted by severity.

    Attributes
    ----------
    severity : ndarray, shape (n_level,)
        Ascending, distinct, positive [unit of the severity].
    hits, total : ndarray, shape (n_level,)
        Number of records detected, and number tested.
    """

    severity: Array
    hits: Array
    total: Array

    @property
    def misses(self) -> Array:
        """Number of records not detected, shape (n_level,)."""
        return self.total - self.hits

    @property
    def span(self) -> tuple[float, float]:
        """Smallest and largest tested severity."""
        return float(self.severity[0]), float(self.severity[-1])

    def pooled(self, n_level: int) -> HitCount:
        """Pool adjacent severities into at most `n_level` levels of about equal size.

        A level is assigned its largest severity, at which the probability of detection is at least the mean
        of the level.
        """
        if self.severity.size <= n_level:
            return self
        twice = 2.0 * np.cumsum(self.total) - self.total  # of counts, so that the division is exact
        level = np.minimum(twice * n_level // (2.0 * self.total.sum()), n_level - 1)
        first = np.flatnonzero(np.diff(level, prepend=-1))
        last = np.append(first[1:], level.size) - 1
        hits, total = (np.add.reduceat(counts, first).astype(float) for counts in (self.hits, self.total))
        return HitCount(self.severity[last], hits, total)


def tally(severity: ArrayLike, outcomes: ArrayLike) -> HitCount:
    """Count faulty records by severity.

    Parameters
    ----------
    severity : array_like, shape (n_record,)
        Positive severity; records without a fault belong to the false alarms.
    outcomes : array_like, shape (n_record,)
        1 detected, 0 not, NaN not measurable.
    """
    levels, values = np.asarray(severity, dtype=float), np.asarray(outcomes, dtype=float)
    is_known = ~np.isnan(values)
    if not is_known.any():
        raise NotStatedError("no faulty record has a score")
    _, first, level_of = np.unique(comparable(levels[is_known]), return_index=True, return_inverse=True)
    hits, total = (
        np.bincount(level_of, counts).astype(float) for counts in (values[is_known], is_known[is_known])
    )
    return HitCount(levels[is_known][first], hits, total).pooled(MOST_SEVERITIES)


MOST_LEVELS = 10
"""Number of levels into which continuous (measured) severities are pooled."""


def isotonic(levels: HitCount) -> Array:
    """Detection rates of levels by isotonic regression, shape (n_level,).

    Ayer, Brunk, Ewing, Reid and Silverman, Annals of Mathematical Statistics 26 (1955) 641: the
    maximum-likelihood estimate among all nondecreasing curves.
    """
    from scipy.optimize import isotonic_regression

    return np.asarray(isotonic_regression(levels.hits / levels.total, weights=levels.total).x, dtype=float)


def last_shown(
    severity: Array, shown: NDArray[np.bool_], probability: float, confidence: float | None
) -> DetectableSeverity:
    """Last level that meets a probability, from the largest downwards, before the first that does not.

    Testing in a fixed sequence needs no correction for multiplicity: Hsu and Berger, Journal of the American
    Statistical Association 94 (1999) 468.

    Parameters
    ----------
    severity : ndarray, shape (n_level,)
        Ascending.
    shown : ndarray of bool, shape (n_level,)
    """
    n_shown = int(np.cumprod(shown[::-1]).sum())
    if not n_shown:
        return DetectableSeverity("above", float(severity[-1]), probability, confidence, "levels")
    first = severity.size - n_shown
    where: Literal["within", "below"] = "within" if first else "below"
    return DetectableSeverity(where, float(severity[first]), probability, confidence, "levels")


def interpolated_level(counted: HitCount, *, probability: float = 0.9) -> DetectableSeverity:
    """Severity at which the isotonic estimate reaches a probability (nonparametric estimate).

    Between levels it is interpolated in the logarithm of the severity: Stylianou and Flournoy, Biometrics 58
    (2002) 171.
    """
    levels = counted.pooled(MOST_LEVELS) if counted.severity.size > 3 * MOST_LEVELS else counted
    level, estimate, asked = levels.severity, comparable(isotonic(levels)), comparable(probability)
    if estimate[-1] < asked:
        return DetectableSeverity("above", float(level[-1]), probability, source="levels")
    after = int(np.argmax(estimate >= asked))
    if not after:
        return DetectableSeverity("below", float(level[0]), probability, source="levels")
    share = (asked - estimate[after - 1]) / (estimate[after] - estimate[after - 1])
    severity = level[after - 1] * (level[after] / level[after - 1]) ** share
    return DetectableSeverity("within", float(severity), probability, source="levels")


AxisName = Literal["log", "linear"]
"""Decimal logarithm of the severity, or its fraction of the largest tested one.

The first suits scores that grow with the logarithm of the severity, the second scores proportional to the
severity, such as its estimate: MIL-HDBK-1823A (2009), appendix G.
"""


def place_on(axis: AxisName, severity: ArrayLike, largest: float) -> Array:
    """Places of severities on an axis, in the same shape."""
    values = np.asarray(severity, dtype=float)
    return np.asarray(np.log10(values) if axis == "log" else values / largest)


MOST_STEPS = 100

CERTAIN = 36.0
"""Predictor at which a probability is 1 in double precision; at its negative it is 0."""


def log_cumulative(predictor: Array) -> Array:
    """ln F of the normal distribution."""
    from scipy.special import log_ndtr

    return np.asarray(log_ndtr(predictor))


def log_likelihood(predictor: Array, tally: HitCount, floor: float) -> float:
    """ln L of P = α + (1 - α) F(predictor), without the binomial coefficients.

    Parameters
    ----------
    predictor : ndarray, shape (n_level,)
    floor : float
        α.
    """
    log_hit, log_above = _logarithms(predictor, floor)
    # 1 − P = (1 − α)(1 − F), without the difference from 1, which would cancel.
    return float(_times(tally.hits, log_hit) + _times(tally.misses, log_above + np.log1p(-floor)))


def maximise(design: Array, offset: Array, tally: HitCount, floor: float, start: float = 0.0) -> Array:
    """Maximum-likelihood coefficients β of the predictor offset + design β.

    Fisher scoring with step halving: McCullagh and Nelder, Generalized Linear Models (1989), section 2.5; the
    floor is Abbott's natural response: Finney, Probit Analysis (1971), chapter 7. If hits and misses are
    separated, the coefficients grow until the likelihood no longer increases.

    Parameters
    ----------
    design : ndarray, shape (n_level, n_coefficient)
    offset : ndarray, shape (n_level,)
    start : float
        Initial value of all coefficients.

    Returns
    -------
    coefficients : ndarray, shape (n_coefficient,)
    """
    coefficients = np.full(design.shape[1], start)
    best = log_likelihood(offset + design @ coefficients, tally, floor)
    for _ in range(MOST_STEPS):
        predictor = np.clip(offset + design @ coefficients, -CERTAIN, CERTAIN)
        score, weight = _score(predictor, tally, floor)
        information = design.T @ (weight[:, None] * design)
        # Least squares, as the information is nearly singular if hits and misses are separated.
        step = np.linalg.lstsq(information, design.T @ score, rcond=1e-12)[0]
        for halving in 0.5 ** np.arange(30):
            trial = coefficients + halving * step
            value = log_likelihood(offset + design @ trial, tally, floor)
            if value >= best:
                break
        else:
            return coefficients
        gain, coefficients, best = value - best, trial, value
        if gain < 1e-9:
            break
    return coefficients


def _logarithms(predictor: Array, floor: float) -> tuple[Array, Array]:
    """ln P, and ln F(-predictor) = ln (1 - P) - ln (1 - α)."""
    log_rise = np.log1p(-floor) + log_cumulative(predictor)
    log_hit = np.logaddexp(np.log(floor), log_rise) if floor else log_rise
    return log_hit, log_cumulative(-predictor)


def _score(predictor: Array, tally: HitCount, floor: float) -> tuple[Array, Array]:
    """Derivative of ln L by the predictor, and its expected information, for each level."""
    log_hit, log_above = _logarithms(predictor, floor)
    log_density = -(predictor**2) / 2.0 - 0.5 * np.log(2.0 * np.pi)
    of_hit = np.exp(np.log1p(-floor) + log_density - log_hit)
    of_miss = np.exp(log_density - log_above)
    # The information of a binomial, P'²/(P (1 − P)), is the product of both terms.
    return tally.hits * of_hit - tally.misses * of_miss, tally.total * of_hit * of_miss


def _times(counts: Array, logarithms: Array) -> Array:
    """Sum of products in which 0 · -∞ is 0; -∞ on overflow."""
    with np.errstate(over="ignore"):
        return np.asarray(np.sum(counts * np.where(counts > 0.0, logarithms, 0.0)))


@dataclass(frozen=True, eq=False)
class PodCurve:
    """POD(a) = α + (1 - α) F((x(a) - µ)/s), with F the normal distribution, x(a) = lg a or a.

    Attributes
    ----------
    false_alarm_rate : float
        α, the floor.
    intercept, slope : float
        -µ/s and 1/s; the slope is 0 if detection does not increase with severity.
    axis : str
        x(a): ``log`` or ``linear``.
    """

    tally: HitCount
    false_alarm_rate: float
    intercept: float
    slope: float
    log_likelihood: float
    axis: AxisName

    @property
    def is_step(self) -> bool:
        """Whether hits and misses are practically separated: fewer than two severities lie on the slope.

        The slope then has no estimate (Albert and Anderson, Biometrika 71 (1984) 1), and likelihood bounds
        are too narrow: results are then based only on the tested levels.
        """
        if self.slope == 0.0 and self.tally.severity.size > 1:
            return not self.tally.hits.any() or not self.tally.misses.any()
        rise = np.round(np.exp(log_cumulative(self.predictor(self.tally.severity))), 6)
        return int(np.sum((rise > 0.01) & (rise < 0.99))) < 2

    def place(self, severity: ArrayLike) -> Array:
        """x(a) of each severity."""
        return place_on(self.axis, severity, self.tally.span[1])

    def predictor(self, severity: ArrayLike) -> Array:
        """(x(a) - µ)/s of each severity."""
        return np.asarray(self.intercept + self.slope * self.place(severity))

    def probability(self, severity: ArrayLike) -> Array:
        """Probability of detection of each severity."""
        rise = np.exp(log_cumulative(self.predictor(severity)))
        return np.asarray(self.false_alarm_rate + (1.0 - self.false_alarm_rate) * rise)

    def quantile_of_rise(self, probability: float) -> float:
        """F⁻¹((p - α)/(1 - α)); -∞ if the floor already reaches p."""
        from scipy.special import ndtri

        share = (probability - self.false_alarm_rate) / (1.0 - self.false_alarm_rate)
        return float(ndtri(share)) if share > 0.0 else -np.inf


def probability_of_detection(
    severity: ArrayLike, outcomes: ArrayLike, *, false_alarm_rate: float = 0.0, axis: AxisName = "log"
) -> PodCurve:
    """Fit a curve of the probability of detection by maximum likelihood.

    Berens, NDE Reliability Data Analysis, ASM Handbook 17 (1989) 689; MIL-HDBK-1823A (2009), appendix G. The
    floor prevents false alarms from counting as detections.

    Parameters
    ----------
    severity : array_like, shape (n_record,)
        Severity of faulty records, positive [unit of the severity].
    outcomes : array_like, shape (n_record,)
        1 if detected, 0 if not, NaN if not measurable.
    false_alarm_rate : float
        α, as measured on healthy records; below 1.
    axis : str
        ``log`` or ``linear`` in severity.
    """
    counted = tally(severity, outcomes)
    x = place_on(axis, counted.severity, counted.span[1])
    intercept, slope = _coefficients(x, counted, false_alarm_rate)
    largest = log_likelihood(intercept + slope * x, counted, false_alarm_rate)
    return PodCurve(counted, false_alarm_rate, intercept, slope, largest, axis)


def _coefficients(x: Array, counted: HitCount, floor: float) -> tuple[float, float]:
    """Intercept and slope; the slope is not negative."""
    nothing, ones = np.zeros_like(x), np.ones_like(x)
    if x.size > 1:
        # About the centre, level and slope hardly depend on each other.
        centre = float(np.average(x, weights=counted.total))
        level, slope = maximise(np.stack((ones, x - centre), axis=1), nothing, counted, floor)
        if slope > 1e-6:  # not 0, as the fit of a flat curve ends
            return float(level - slope * centre), float(slope)
    (level,) = maximise(ones[:, None], nothing, counted, floor)
    return float(level), 0.0


MOST_CELLS = 10

SMALLEST_EXPECTED = 2.0
"""Minimum expected number of hits and of misses per cell."""


def lack_of_fit(curve: PodCurve) -> float:
    """P-value of Pearson's test over cells of adjacent severities with at least two expected hits and misses.

    Hosmer and Lemeshow, Communications in Statistics A 9 (1980) 1043; Cochran, Biometrics 10 (1954) 417, on
    the minimum expected count. A small p-value means that the quantiles of the curve must not be used; NaN if
    there are too few cells.
    """
    from scipy.special import chdtrc

    counted = curve.tally
    expected = counted.total * curve.probability(counted.severity)
    cells = _cells(expected, counted.total)
    hits, expects, total = (np.bincount(cells, values) for values in (counted.hits, expected, counted.total))
    # Level and slope are fitted.
    degrees = hits.size - 2
    if degrees < 1:
        return math.nan
    statistic = float(np.sum((hits - expects) ** 2 * total / (expects * (total - expects))))
    return float(chdtrc(degrees, statistic))


def _cells(expected: Array, total: Array) -> np.ndarray:
    """Cell of each level, shape (n_level,), formed from below; the remainder joins the last cell."""
    size = total.sum() if total.size > MOST_CELLS else 0.0
    cells, cell, hits, count = np.empty(total.size, dtype=int), 0, 0.0, 0.0
    for index in range(total.size):
        cells[index] = cell
        hits, count = hits + expected[index], count + total[index]
        # A flat curve expects whole numbers, up to the accuracy of its fit.
        if round(min(hits, count - hits), 6) >= SMALLEST_EXPECTED and count * MOST_CELLS >= size:
            cell, hits, count = cell + 1, 0.0, 0.0
    return np.minimum(cells, max(cell - 1, 0))


def deficit(curve: PodCurve, x: float, rise: float) -> float:
    """2 (ln L_max - ln L) of the best increasing curve whose predictor at `place` on the axis is `rise`."""
    distance = curve.place(curve.tally.severity) - x
    offset = np.full_like(distance, rise)
    (slope,) = maximise(distance[:, None], offset, curve.tally, curve.false_alarm_rate, curve.slope)
    predictor = offset + max(float(slope), 0.0) * distance
    return 2.0 * (curve.log_likelihood - log_likelihood(predictor, curve.tally, curve.false_alarm_rate))


def quantile_of_chi_square(confidence: float) -> float:
    """Quantile of χ² with one degree of freedom."""
    from scipy.special import chdtri

    return float(chdtri(1.0, 1.0 - confidence))


def smallest_detectable(
    curve: PodCurve, *, probability: float = 0.9, confidence: float | None = 0.95
) -> DetectableSeverity:
    """Severity that is detected with a given probability and confidence; by default q90/95.

    With a confidence, it is the largest severity q for which 2 (ln L_max - ln L(q)) ≤ χ²₁(2γ - 1), where L(q)
    is the maximum likelihood of curves with POD(q) = p: Venzon and Moolgavkar, Applied Statistics 37 (1988)
    87; MIL-HDBK-1823A (2009), appendix G. It is too small if hits and misses are separated (`is_step`).

    Parameters
    ----------
    probability : float
        p.
    confidence : float or None
        Confidence γ ≥ 0.5 that the severity is not larger; None for the estimate.

    Returns
    -------
    DetectableSeverity
        Severity within the tested ones, or the side on which it lies.
    """
    rise, first, last = curve.quantile_of_rise(probability), *curve.place(curve.tally.span)
    if rise == -np.inf:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    x = _where(curve, rise)
    if confidence is not None and x <= last:
        x = _upper(curve, rise, max(x, first), last, quantile_of_chi_square(2.0 * confidence - 1.0))
    if x > last:
        return DetectableSeverity("above", curve.tally.span[1], probability, confidence)
    if x <= first:
        return DetectableSeverity("below", curve.tally.span[0], probability, confidence)
    severity = 10.0 ** float(x) if curve.axis == "log" else float(x) * curve.tally.span[1]
    return DetectableSeverity("within", severity, probability, confidence)


def _where(curve: PodCurve, rise: float) -> float:
    """Place at which the fitted predictor is `rise`; infinite if the curve is flat."""
    if curve.slope:
        return (rise - curve.intercept) / curve.slope
    return -np.inf if curve.intercept >= rise - 1e-6 else np.inf


def _upper(curve: PodCurve, rise: float, start: float, last: float, drop: float) -> float:
    """Place of the bound: at least `start`, ∞ if it exceeds the tested severities."""
    from scipy.optimize import brentq

    if deficit(curve, last, rise) < drop:
        return np.inf
    if deficit(curve, start, rise) >= drop:
        return start
    return float(brentq(lambda x: deficit(curve, x, rise) - drop, start, last, xtol=1e-7))


INNER = (0.05, 0.95)
"""Probabilities of the limits of the inner 90 % range."""

BEYOND = 2.5
"""Minimum expected number of records beyond a quantile; with fewer, nominal 95 % intervals have less than 90
% coverage."""

N_DRAW = 1000


@dataclass(frozen=True)
class Spread(Estimate):
    """A relative spread of scores with its two-sided interval, from `n_record` records."""

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
    drawn = np.cumsum(generator.dirichlet(distances, N_DRAW), axis=1)[:, :-1]
    # Expected probabilities of the order statistics.
    at = np.arange(1, n_space) / n_space
    return np.interp(probabilities, at, ordered), np.interp(drawn, at, ordered)


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
        medians = [
            quantiles_and_draws(np.asarray(own, dtype=float), [0.5], draw) for own in (healthy, *faulty)
        ]
        shifts = np.array([float(median[0]) for median, _ in medians])[1:] - medians[0][0]
        drawn = medians[-1][1] - medians[0][1]
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
