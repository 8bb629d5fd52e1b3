"""Hits at each severity, and severities from them without a curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import clopper_pearson
from hydrofdi.evaluation.scores import Array


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

    def sentence(self, unit: str = "", scale: float = 1.0) -> str:
        """Severity as a text for readers.

        Parameters
        ----------
        unit : str
        scale : float
            Factor from the severity to this unit.
        """
        number = f"{self.severity * scale:.3g} {unit}".rstrip()
        words = {"below": f"at most {number}", "within": number, "above": f"not detectable up to {number}"}
        return words[self.place]


MOST_SEVERITIES = 1000
"""Maximum number of distinct severities; closer ones are merged."""


@dataclass(frozen=True, eq=False)
class Tally:
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

    def pooled(self, n_level: int) -> Tally:
        """Pool adjacent severities into at most `n_level` levels of about equal size.

        A level is assigned its largest severity, at which the probability of detection is at least the mean
        of the level.
        """
        if self.severity.size <= n_level:
            return self
        middle = np.cumsum(self.total) - self.total / 2.0
        places = np.minimum((middle * n_level / self.total.sum()).astype(int), n_level - 1)
        first = np.flatnonzero(np.diff(places, prepend=-1))
        last = np.append(first[1:], places.size) - 1
        hits, total = (np.add.reduceat(counts, first).astype(float) for counts in (self.hits, self.total))
        return Tally(self.severity[last], hits, total)


def tally(severity: ArrayLike, outcomes: ArrayLike) -> Tally:
    """Count faulty records by severity.

    Parameters
    ----------
    severity : array_like, shape (n_record,)
        Positive severity; records without a fault belong to the false alarms.
    outcomes : array_like, shape (n_record,)
        1 detected, 0 not, NaN not measurable.

    Raises
    ------
    ValueError
        A severity is not a positive number.
    NotStatedError
        No record has a score.
    """
    levels, values = np.asarray(severity, dtype=float), np.asarray(outcomes, dtype=float)
    if not np.all((levels > 0.0) & np.isfinite(levels)):
        raise ValueError("severities must be positive")
    is_known = ~np.isnan(values)
    if not is_known.any():
        raise NotStatedError("no faulty record has a score")
    distinct, places = np.unique(levels[is_known], return_inverse=True)
    hits, total = (
        np.bincount(places, counts).astype(float) for counts in (values[is_known], is_known[is_known])
    )
    return Tally(distinct, hits, total).pooled(MOST_SEVERITIES)


MOST_LEVELS = 10
"""Number of levels into which continuous (measured) severities are pooled."""


def isotonic(levels: Tally) -> Array:
    """Detection rates of levels by isotonic regression, shape (n_level,).

    Ayer, Brunk, Ewing, Reid and Silverman, Annals of Mathematical Statistics 26 (1955) 641: the
    maximum-likelihood estimate among all nondecreasing curves.
    """
    from scipy.optimize import isotonic_regression

    return np.asarray(isotonic_regression(levels.hits / levels.total, weights=levels.total).x, dtype=float)


def detected_level(
    counted: Tally, *, probability: float = 0.9, confidence: float | None = 0.95
) -> DetectableSeverity:
    """Smallest tested level such that it and all larger levels are detected with a given probability.

    With a confidence, levels are tested from the largest downwards by the one-sided binomial bound (29 of 29
    show 90 % with 95 % confidence) until the first fails. Testing in a fixed sequence needs no correction for
    multiplicity: Hsu and Berger, Journal of the American Statistical Association 94 (1999) 468.

    Parameters
    ----------
    counted : Tally
    probability : float
    confidence : float or None
        None for the isotonic estimate.
    """
    levels = _levels(counted)
    if confidence is None:
        shown = isotonic(levels) >= probability
    else:
        two_sided = 2.0 * confidence - 1.0
        bounds = [clopper_pearson(h, n, two_sided)[0] for h, n in zip(levels.hits, levels.total, strict=True)]
        shown = np.array(bounds) >= probability
    return last_shown(levels.severity, shown, probability, confidence)


def last_shown(
    severity: Array, shown: NDArray[np.bool_], probability: float, confidence: float | None
) -> DetectableSeverity:
    """Last level that meets a probability, from the largest downwards, before the first that does not.

    Parameters
    ----------
    severity : ndarray, shape (n_level,)
        Ascending.
    shown : ndarray of bool, shape (n_level,)
    probability : float
    confidence : float or None
    """
    n_shown = int(np.cumprod(shown[::-1]).sum())
    if not n_shown:
        return DetectableSeverity("above", float(severity[-1]), probability, confidence, "levels")
    place = severity.size - n_shown
    where: Literal["within", "below"] = "within" if place else "below"
    return DetectableSeverity(where, float(severity[place]), probability, confidence, "levels")


def interpolated_level(counted: Tally, *, probability: float = 0.9) -> DetectableSeverity:
    """Severity at which the isotonic estimate reaches a probability (nonparametric estimate).

    Between levels it is interpolated in the logarithm of the severity: Stylianou and Flournoy, Biometrics 58
    (2002) 171.

    Parameters
    ----------
    counted : Tally
    probability : float
    """
    levels = _levels(counted)
    level, estimate = levels.severity, isotonic(levels)
    if estimate[-1] < probability:
        return DetectableSeverity("above", float(level[-1]), probability, source="levels")
    after = int(np.argmax(estimate >= probability))
    if not after:
        return DetectableSeverity("below", float(level[0]), probability, source="levels")
    share = (probability - estimate[after - 1]) / (estimate[after] - estimate[after - 1])
    severity = level[after - 1] * (level[after] / level[after - 1]) ** share
    return DetectableSeverity("within", float(severity), probability, source="levels")


def _levels(counted: Tally) -> Tally:
    return counted.pooled(MOST_LEVELS) if counted.severity.size > 3 * MOST_LEVELS else counted
