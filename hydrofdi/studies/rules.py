"""Rules for the evaluation of scores."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.pod.curve import Link
from hydrofdi.evaluation.scores import share_between_0_and_1
from hydrofdi.evaluation.tail import THRESHOLDS, ThresholdKind
from hydrofdi.evaluation.threshold import Threshold, records_needed


@dataclass(frozen=True)
class Rules:
    """Requirements on a detector, and confidence levels.

    Attributes
    ----------
    false_alarm_rate : float
        Design false-alarm rate α of thresholds.
    confidence : float
        Confidence level γ of all intervals and bounds.
    probability : float
        Probability of detection at the stated severity.
    threshold : str
        ``quantile``, ``tolerance`` or ``tail``.
    link : str
        Link of the detection curve, ``probit`` or ``logit``; normally distributed scores give a probit curve.
    n_tried : int
        Number of scores among which this one was chosen.
    """

    false_alarm_rate: float = 0.01
    confidence: float = 0.95
    probability: float = 0.9
    threshold: ThresholdKind = "quantile"
    link: Link = "probit"
    n_tried: int = 1

    def __post_init__(self) -> None:
        """Check that rates and probabilities lie between 0 and 1.

        Raises
        ------
        ValueError
            One of them does not.
        """
        share_between_0_and_1("the false-alarm rate", self.false_alarm_rate)
        share_between_0_and_1("the confidence", self.confidence)
        share_between_0_and_1("the probability", self.probability)

    def set_threshold(self, healthy: ArrayLike, direction: Direction) -> Threshold:
        """Set a threshold from healthy fit scores, shape (n_record,).

        Raises
        ------
        NotStatedError
            There are too few scores, or the tail model is rejected.
        """
        method = THRESHOLDS[self.threshold]
        return method(healthy, self.false_alarm_rate, direction=direction, confidence=self.confidence)

    def records_for_threshold(self, direction: Direction) -> int:
        """Number of healthy fit records that a threshold in this direction needs; 0 if one is enough."""
        try:
            self.set_threshold(np.zeros(1), direction)
        except NotStatedError as refusal:
            return refusal.records_needed or 0
        return 0

    @property
    def records_for_false_alarms(self) -> int:
        """Minimum number of records for a rate: without any alarm they demonstrate the false-alarm rate."""
        return records_needed(self.false_alarm_rate, self.confidence)

    @property
    def records_for_detection(self) -> int:
        """Number of records that demonstrate the probability if all are detected: 29 for 90/95."""
        return records_needed(1.0 - self.probability, self.confidence)
