"""By which rules scores are judged."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from numpy.typing import ArrayLike

from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.pod.likelihood import Link
from hydrofdi.evaluation.scores import share_between_0_and_1
from hydrofdi.evaluation.tail import tail_threshold
from hydrofdi.evaluation.threshold import Threshold, quantile_threshold
from hydrofdi.evaluation.tolerance import records_needed, tolerance_threshold


class ThresholdKind(StrEnum):
    """How a threshold follows from healthy scores."""

    QUANTILE = "quantile"
    TOLERANCE = "tolerance"
    TAIL = "tail"


@dataclass(frozen=True)
class Rules:
    """What is asked of a detector, and how surely.

    Attributes
    ----------
    false_alarm_rate : float
        α, that thresholds are set for.
    confidence : float
        γ, of every interval and bound.
    probability : float
        Of detection, at the severity that is stated.
    threshold : ThresholdKind
    link : str
        ``probit`` or ``logit``, of the curve of detection: normal scores beyond a threshold are a probit.
    n_tried : int
        Number of scores among which this one was chosen.
    """

    false_alarm_rate: float = 0.01
    confidence: float = 0.95
    probability: float = 0.9
    threshold: ThresholdKind = ThresholdKind.QUANTILE
    link: Link = "probit"
    n_tried: int = 1

    def __post_init__(self) -> None:
        """Check that rates are rates.

        Raises
        ------
        ValueError
            One does not lie between 0 and 1.
        """
        share_between_0_and_1("the false-alarm rate", self.false_alarm_rate)
        share_between_0_and_1("the confidence", self.confidence)
        share_between_0_and_1("the probability", self.probability)

    def set_threshold(self, healthy: ArrayLike, direction: Direction) -> Threshold:
        """The threshold that healthy fit scores, shape (n_record,), set.

        Raises
        ------
        NotStatedError
            They are too few, or the model of their tail does not hold.
        """
        rate, confidence = self.false_alarm_rate, self.confidence
        match self.threshold:
            case ThresholdKind.QUANTILE:
                return quantile_threshold(healthy, rate, direction=direction, confidence=confidence)
            case ThresholdKind.TOLERANCE:
                return tolerance_threshold(healthy, rate, direction=direction, confidence=confidence)
            case ThresholdKind.TAIL:
                return tail_threshold(healthy, rate, direction=direction, confidence=confidence)

    @property
    def records_for_false_alarms(self) -> int:
        """Number of records that show the false-alarm rate where none of them alarms; below it no rate is."""
        return records_needed(self.false_alarm_rate, self.confidence)

    @property
    def records_for_detection(self) -> int:
        """Number of records that show the probability where all of them are detected: 29 for 90/95."""
        return records_needed(1.0 - self.probability, self.confidence)
