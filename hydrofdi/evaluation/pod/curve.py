"""Probability of detection as a function of severity: curves fitted by maximum likelihood."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.evaluation.pod.axis import Axis, AxisName
from hydrofdi.evaluation.pod.likelihood import (
    Link,
    inverse_cumulative,
    log_cumulative,
    log_likelihood,
    maximise,
)
from hydrofdi.evaluation.pod.tally import Tally, tally
from hydrofdi.evaluation.scores import Array


@dataclass(frozen=True, eq=False)
class PodCurve:
    """POD(a) = α + (1 - α) F((x(a) - µ)/s), with F the logistic or the normal distribution, x(a) = lg a or a.

    Attributes
    ----------
    tally : Tally
        Hits and misses that the curve is fitted to.
    false_alarm_rate : float
        α, the floor.
    link : str
        ``logit`` or ``probit``.
    intercept, slope : float
        -µ/s and 1/s; the slope is 0 if detection does not increase with severity.
    log_likelihood : float
    axis : Axis
        x(a).
    """

    tally: Tally
    false_alarm_rate: float
    link: Link
    intercept: float
    slope: float
    log_likelihood: float
    axis: Axis

    @property
    def is_step(self) -> bool:
        """Whether hits and misses are practically separated: fewer than two severities lie on the slope.

        The slope then has no estimate (Albert and Anderson, Biometrika 71 (1984) 1), and likelihood bounds
        are too narrow: results are then based only on the tested levels.
        """
        if self.slope == 0.0 and self.tally.severity.size > 1:
            return not self.tally.hits.any() or not self.tally.misses.any()
        rise = np.exp(log_cumulative(self.predictor(self.tally.severity), self.link))
        return int(np.sum((rise > 0.01) & (rise < 0.99))) < 2

    def predictor(self, severity: ArrayLike) -> Array:
        """(x(a) - µ)/s of each severity."""
        return np.asarray(self.intercept + self.slope * self.axis.place(severity))

    def probability(self, severity: ArrayLike) -> Array:
        """Probability of detection of each severity."""
        rise = np.exp(log_cumulative(self.predictor(severity), self.link))
        return np.asarray(self.false_alarm_rate + (1.0 - self.false_alarm_rate) * rise)

    def quantile_of_rise(self, probability: float) -> float:
        """F⁻¹((p - α)/(1 - α)); -∞ if the floor already reaches p."""
        share = (probability - self.false_alarm_rate) / (1.0 - self.false_alarm_rate)
        return inverse_cumulative(share, self.link) if share > 0.0 else -np.inf


def probability_of_detection(
    severity: ArrayLike,
    outcomes: ArrayLike,
    *,
    false_alarm_rate: float = 0.0,
    link: Link = "logit",
    axis: AxisName = "log",
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
    link : str
    axis : str
        ``log`` or ``linear`` in severity.

    Raises
    ------
    ValueError
        A severity is not positive, or the false-alarm rate is not between 0 and 1.
    NotStatedError
        No record has a score.
    """
    if not 0.0 <= false_alarm_rate < 1.0:
        raise ValueError(f"the false-alarm rate must be from 0 to 1; found {false_alarm_rate}")
    counted = tally(severity, outcomes)
    along = Axis(axis, counted.span[1])
    places = along.place(counted.severity)
    intercept, slope = _coefficients(places, counted, false_alarm_rate, link)
    largest = log_likelihood(intercept + slope * places, counted, false_alarm_rate, link)
    return PodCurve(counted, false_alarm_rate, link, intercept, slope, largest, along)


def _coefficients(places: Array, counted: Tally, floor: float, link: Link) -> tuple[float, float]:
    """Intercept and slope; the slope is not negative."""
    nothing, ones = np.zeros_like(places), np.ones_like(places)
    if places.size > 1:
        centre = float(np.average(places, weights=counted.total))
        level, slope = maximise(np.stack((ones, places - centre), axis=1), nothing, counted, floor, link)
        if slope > 0.0:
            return float(level - slope * centre), float(slope)
    (level,) = maximise(ones[:, None], nothing, counted, floor, link)
    return float(level), 0.0
