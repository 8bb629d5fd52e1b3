"""Alarm rates, ROC curves and their areas, with intervals, of independent records and of groups."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array, Direction, measurable
from hydrofdi.evaluation.threshold import Threshold

Rule = Callable[[Array], Threshold]
"""Function that sets a threshold from healthy scores, such as a partial `tolerance_threshold`."""


@dataclass(frozen=True)
class HealthyPair:
    """Comparison of two healthy groups; without group differences there is no effect.

    Attributes
    ----------
    area : Area
        Area under the ROC curve of the test group against the fit group; 0.5 if they do not differ.
    rate : Rate or None
        False alarms of the test group at the threshold of the fit group; None if there is no threshold.
    """

    fit_group: str
    test_group: str
    area: Area
    rate: Rate | None
    refusal: str = ""


def left_out_outcomes(healthy: ArrayLike, groups: Sequence[str], rule: Rule) -> Array:
    """Alarms of each group at the threshold of all others: cross-validation by group, Stone (1974).

    Journal of the Royal Statistical Society B 36, 111. `alarm_rate` with `groups` gives the rate of all.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)

    Returns
    -------
    outcomes : ndarray, shape (n_record,)
    """
    scores, names = np.asarray(healthy, dtype=float), np.asarray(groups)
    distinct = np.unique(names)
    if distinct.size < 2:
        raise NotStatedError("leaving a group out needs two groups or more")
    outcomes = np.empty(scores.size)
    for name in distinct:
        outcomes[names == name] = rule(scores[names != name]).outcomes(scores[names == name])
    return outcomes


def healthy_against_healthy(
    healthy: ArrayLike, groups: Sequence[str], rule: Rule, *, confidence: float = 0.95
) -> tuple[HealthyPair, ...]:
    """Compare every healthy group with every other, as if the second were faulty.

    If the score separates healthy groups, separation elsewhere is not due to the fault alone. Pairs with a
    group without scores are omitted.

    Parameters
    ----------
    healthy : array_like, shape (n_record,)
    """
    scores, names = np.asarray(healthy, dtype=float), np.asarray(groups)
    parts = {str(name): scores[names == name] for name in dict.fromkeys(groups)}
    known = [name for name, own in parts.items() if not np.all(np.isnan(own))]
    pairs = []
    for fit, test in permutations(known, 2):
        area = area_under_curve(parts[fit], parts[test], confidence=confidence)
        try:
            rate = alarm_rate(rule(parts[fit]).outcomes(parts[test]), confidence=confidence)
            pairs.append(HealthyPair(fit, test, area, rate))
        except NotStatedError as refusal:
            pairs.append(HealthyPair(fit, test, area, None, str(refusal)))
    return tuple(pairs)


@dataclass(frozen=True)
class Rate:
    """An alarm rate with its two-sided interval.

    Attributes
    ----------
    count, total : int
        Number of alarms, and of records with a score.
    not_measurable : int
        Number of further records without a score.
    low, high : float
        Limits of the interval; 0 and 1 if there are no records.
    n_group : int or None
        Number of groups of possibly dependent records; None if all records are independent.
    """

    count: int
    total: int
    not_measurable: int
    low: float
    high: float
    confidence: float
    n_group: int | None = None

    @property
    def value(self) -> float:
        """The rate; NaN if there are no records."""
        return self.count / self.total if self.total else math.nan


def clopper_pearson(count: float, total: float, confidence: float = 0.95) -> tuple[float, float]:
    """Exact (Clopper-Pearson) interval of a rate, with error probability (1 - confidence)/2 at each end.

    Clopper and Pearson, Biometrika 26 (1934) 404. One limit alone has confidence (1 + γ)/2.

    Parameters
    ----------
    count, total : float
        Need not be integers: effective numbers of records are allowed.
    """
    from scipy.special import betaincinv

    each = (1.0 - confidence) / 2.0
    # At no alarm or all, a parameter of the Beta distribution is 0, and the limit is the end.
    low = float(betaincinv(count, total - count + 1.0, each)) if count > 0.0 else 0.0
    high = float(betaincinv(count + 1.0, total - count, 1.0 - each)) if count < total else 1.0
    return low, high


def alarm_rate(outcomes: ArrayLike, *, groups: Sequence[str] | None = None, confidence: float = 0.95) -> Rate:
    """Alarm rate of one population.

    With groups, the interval uses the effective number of records: the number of independent records that
    would give the observed variance between groups, with Student's quantile for the number of groups. It is
    at most the number of records; if no record or every record alarms, it is the number of groups. After Korn
    and Graubard, Survey Methodology 24 (1998) 193.

    If rare alarms come in bursts, the interval is too short: nominal 95 % intervals covered the rate in about
    80 of 100 repeats, at a rate of 1 % in 30 groups of 40 records with an intra-group correlation of 0.2.

    Parameters
    ----------
    outcomes : array_like, shape (n_record,)
        1 for an alarm, 0 for none, NaN if not measurable.
    groups : sequence of str, length n_record, optional
        Equal for dependent records, such as those of one unit or day.
    """
    values = np.asarray(outcomes, dtype=float)
    is_known = ~np.isnan(values)
    known, missing = values[is_known], int((~is_known).sum())
    total, count = known.size, int(known.sum())
    if not total:
        return Rate(0, 0, missing, 0.0, 1.0, confidence)
    effective, n_group = float(total), None
    if groups is not None:
        effective, n_group = _effective_number(known, np.asarray(groups)[is_known], confidence)
    # The same rate, of fewer records.
    low, high = clopper_pearson(count * effective / total, effective, confidence)
    return Rate(count, total, missing, low, high, confidence, n_group)


def _effective_number(outcomes: Array, groups: np.ndarray, confidence: float) -> tuple[float, int]:
    from scipy.special import stdtrit

    _, group_of = np.unique(groups, return_inverse=True)
    sizes, total, share = np.bincount(group_of), outcomes.size, float(outcomes.mean())
    n_group = sizes.size
    # Sums over groups, not means: the rate is a ratio of totals, and groups may differ in size.
    departures = np.bincount(group_of, outcomes) - share * sizes
    if n_group == 1 or share in (0.0, 1.0):
        return float(n_group), n_group
    variance = n_group / (n_group - 1) * float(np.sum(departures**2)) / total**2
    quantile = (1.0 + confidence) / 2.0
    # Student's quantile is larger for groups than for records, which is worth fewer records.
    fewer = float(stdtrit(total - 1, quantile) / stdtrit(n_group - 1, quantile)) ** 2
    # Groups that agree more than independent records would are worth no more than these.
    return min(float(total), fewer * share * (1.0 - share) / max(variance, 1e-300)), n_group


def simultaneous_confidence(confidence: float, n_tried: int) -> float:
    """Confidence level per interval for a simultaneous level γ, by Bonferroni: 1 - (1 - γ)/n.

    Dunn, Journal of the American Statistical Association 56 (1961) 52. The bound of the best of n indicators
    is a valid q90/95 only at this level.
    """
    return 1.0 - (1.0 - confidence) / n_tried


def confidence_text(confidence: float) -> str:
    """A confidence level in percent, with two digits of its difference from 100: 95, 99.29, 99.9988."""
    rest = 100.0 * (1.0 - confidence)
    digits = max(1 - math.floor(math.log10(rest)), 0) if rest > 0.0 else 0
    return f"{round(100.0 * confidence, digits):.10g}"


def roc_curve(healthy: ArrayLike, faulty: ArrayLike) -> tuple[Array, Array]:
    """Empirical ROC curve: false-alarm and detection rates; larger scores are more suspicious.

    Fawcett, Pattern Recognition Letters 27 (2006) 861: equal scores give one point, so that they count half
    in the area.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)

    Returns
    -------
    false_alarm_rate, detection_rate : ndarray, shape (n_point,)
        From (0, 0) to (1, 1), by descending threshold.
    """
    below, above = _of_both_kinds(healthy, faulty)
    distinct = np.unique(np.concatenate((below, above)))[::-1]
    return _share_at_or_above(below, distinct), _share_at_or_above(above, distinct)


def _of_both_kinds(healthy: ArrayLike, faulty: ArrayLike) -> tuple[Array, Array]:
    """The scores that are not NaN; refused if there are none of one kind."""
    below, above = measurable(healthy)[0], measurable(faulty)[0]
    if not below.size or not above.size:
        raise NotStatedError(f"a ROC curve needs scores of both kinds, not {below.size} and {above.size}")
    return below, above


def _share_at_or_above(scores: Array, thresholds: Array) -> Array:
    below = np.searchsorted(np.sort(scores), thresholds, "left")
    # The first point is that of a threshold above all scores.
    return np.concatenate(([0.0], 1.0 - below / scores.size))


@dataclass(frozen=True)
class Area:
    """Area under a ROC curve: the probability that a faulty record scores above a healthy one.

    Attributes
    ----------
    value, low, high : float
        Area and its two-sided interval.
    n_healthy, n_faulty : int
        Number of records with a score.
    """

    value: float
    low: float
    high: float
    n_healthy: int
    n_faulty: int


def placements(healthy: Array, faulty: Array) -> tuple[Array, Array]:
    """Fraction of faulty scores above each healthy one, and of healthy scores below each faulty one.

    Equal scores count half. These are the structural components of DeLong, DeLong and Clarke-Pearson,
    Biometrics 44 (1988) 837, computed from ranks in O(n log n) as in Sun and Xu, IEEE Signal Processing
    Letters 21 (2014) 1389.

    Parameters
    ----------
    healthy : ndarray, shape (n_healthy,)
    faulty : ndarray, shape (n_faulty,)
        Without NaN.
    """
    return 1.0 - share_below(faulty, healthy), share_below(healthy, faulty)


def share_below(scores: Array, of: Array) -> Array:
    """Fraction of `scores` below each score in `of`, equal ones counted half; shape of `of`."""
    ordered = np.sort(scores)
    # Both sides together count equal scores half, in whole numbers.
    twice = np.searchsorted(ordered, of, "left") + np.searchsorted(ordered, of, "right")
    return np.asarray(twice / (2.0 * scores.size))


def area_under_curve(healthy: ArrayLike, faulty: ArrayLike, *, confidence: float = 0.95) -> Area:
    """Area under the ROC curve of independent records; larger scores are more suspicious.

    The interval is DeLong's on the logit of the area. If its variance is undefined (perfect separation, a
    single record), it is method 5 of Newcombe, Statistics in Medicine 25 (2006) 559.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
    """
    below, above = _of_both_kinds(healthy, faulty)
    of_healthy, of_faulty = placements(below, above)
    pairs = 2.0 * below.size * above.size  # halves of pairs are whole numbers, whose sum is exact
    value = float(np.rint(2.0 * below.size * of_faulty).sum() / pairs)
    variance = _variance(of_healthy) + _variance(of_faulty)
    low, high = _interval(value, variance, below.size, above.size, confidence)
    return Area(value, low, high, below.size, above.size)


def _variance(components: Array) -> float:
    return float(components.var(ddof=1)) / components.size if components.size > 1 else math.nan


def _interval(value: float, variance: float, n: int, m: int, confidence: float) -> tuple[float, float]:
    from scipy.special import ndtri

    z = float(ndtri((1.0 + confidence) / 2.0))
    if variance > 0.0:
        return _on_logit(value, z * math.sqrt(variance))
    # The upper limit is the lower one with healthy and faulty exchanged.
    return _newcombe(value, n, m, z), 1.0 - _newcombe(1.0 - value, m, n, z)


def _on_logit(value: float, spread: float) -> tuple[float, float]:
    from scipy.special import expit, logit

    # The slope of the logit is 1/(A (1 − A)); limits on it stay between 0 and 1.
    away = spread / (value * (1.0 - value))
    low, high = expit(logit(value) + np.array([-away, away]))
    return float(low), float(high)


def _newcombe(value: float, n: int, m: int, z: float) -> float:
    """Lower limit, at a distance of z standard deviations from `value`, under the exponential model."""
    from scipy.optimize import brentq

    def distance(area: float) -> float:
        pairs = (1.0 - area) / (2.0 - area) + area / (1.0 + area)
        variance = area * (1.0 - area) * (1.0 + ((n + m) / 2.0 - 1.0) * pairs) / (n * m)
        return value - area - z * math.sqrt(variance)

    # Not at the estimate itself, which is a second zero of the distance if it is 1.
    return float(brentq(distance, 0.0, value - 1e-12)) if value > 1e-9 else 0.0


def learned_direction(healthy: ArrayLike, faulty: ArrayLike, *, confidence: float = 0.95) -> Direction:
    """Direction learned from fit records; both if it is not significant.

    This requires faulty fit records, which must not be used for testing afterwards.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
        Scores of fit records.
    confidence : float
        Confidence level of the interval of the area under the ROC curve, which must exclude 1/2.
    """
    area = area_under_curve(healthy, faulty, confidence=confidence)
    if area.low > 0.5:
        return Direction.RISING
    return Direction.FALLING if area.high < 0.5 else Direction.BOTH


FEWEST_GROUPS, MANY_GROUPS = 5, 30
"""Minimum number of groups for an interval, and for a reliable estimate of the variance between groups."""

N_DRAW = 2000


def grouped_area(
    healthy: ArrayLike,
    faulty: ArrayLike,
    healthy_groups: Sequence[str],
    faulty_groups: Sequence[str],
    *,
    confidence: float = 0.95,
    many: int = MANY_GROUPS,
) -> Area:
    """Area under the ROC curve, with an interval over groups of records that may depend on each other.

    A group may contain records of both kinds, such as those of one actuator before and after a fault. With
    many groups, the interval is from the sums of DeLong's components in each, on the logit of the area:
    Obuchowski, Biometrics 53 (1997) 567. With fewer, groups are resampled: Davison and Hinkley, Bootstrap
    Methods and their Application (1997), section 3.8; percentiles are widened after Hesterberg, The American
    Statistician 69 (2015) 371. With perfect separation it is that of independent records, of few groups as
    many as there are groups.

    Parameters
    ----------
    healthy, faulty : array_like, shape (n_record,)
    many : int
        Number of groups from which on there are many.
    """
    area = area_under_curve(healthy, faulty, confidence=confidence)
    pairs = ((np.asarray(healthy, float), healthy_groups), (np.asarray(faulty, float), faulty_groups))
    (below, mine), (above, theirs) = (
        (own[~np.isnan(own)], np.asarray(names)[~np.isnan(own)]) for own, names in pairs
    )
    _, group_of = np.unique(np.concatenate((mine, theirs)), return_inverse=True)
    if (n_group := int(group_of.max()) + 1) < FEWEST_GROUPS:
        raise NotStatedError(f"an interval over groups needs {FEWEST_GROUPS} groups, not {n_group}")
    interval = _of_sums if n_group >= many else _of_draws
    low, high = interval(area, below, above, group_of, n_group, confidence)
    return replace(area, low=low, high=high)


def _of_sums(
    area: Area, below: Array, above: Array, group_of: NDArray[np.intp], n_group: int, confidence: float
) -> tuple[float, float]:
    from scipy.special import stdtrit

    # Both kinds of a group add up before they are squared, so that their dependence counts.
    departures = np.concatenate([(own - area.value) / own.size for own in placements(below, above)])
    sums = np.bincount(group_of, departures)
    deviation = math.sqrt(n_group / (n_group - 1) * float(np.sum(sums**2)))
    if deviation < 1e-12:
        return area.low, area.high
    return _on_logit(area.value, float(stdtrit(n_group - 1, (1.0 + confidence) / 2.0)) * deviation)


def _of_draws(
    area: Area, below: Array, above: Array, group_of: NDArray[np.intp], n_group: int, confidence: float
) -> tuple[float, float]:
    from scipy.special import ndtr, stdtrit

    order = np.argsort(above)
    above, mine, theirs = above[order], group_of[: below.size], group_of[below.size :][order]
    sizes, others = np.bincount(mine, minlength=n_group), np.bincount(theirs, minlength=n_group)
    # Wins between two groups are counted once, so that resampling needs no sorting.
    wins = np.zeros((n_group, n_group))
    for group in np.flatnonzero(sizes):
        share = share_below(below[mine == group], above)
        wins[group] = sizes[group] * np.bincount(theirs, share, minlength=n_group)
    counts = np.random.default_rng(0).multinomial(n_group, np.full(n_group, 1.0 / n_group), size=N_DRAW)
    pairs = (counts @ sizes) * (counts @ others)
    # A pair of groups counts as often as both are drawn; a draw without one kind has no area.
    drawn = np.einsum("bi,ij,bj->b", counts, wins, counts, optimize=True)[pairs > 0] / pairs[pairs > 0]
    if drawn.size and np.ptp(drawn) < 1e-12:  # perfect separation: groups count as one record each
        n_healthy, n_faulty = int(np.sum(sizes > 0)), int(np.sum(others > 0))
        return _interval(area.value, math.nan, n_healthy, n_faulty, confidence)
    # Percentiles at Student's quantile instead of the normal one, as a bootstrap of few groups is too narrow.
    wide = math.sqrt(n_group / (n_group - 1)) * stdtrit(n_group - 1, (1.0 + confidence) / 2.0)
    low, high = np.quantile(drawn, [ndtr(-wide), ndtr(wide)])
    return float(low), float(high)
