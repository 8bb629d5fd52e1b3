"""What is asked of detectors, before training and in studies."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from numpy.typing import ArrayLike
from pydantic import Field

from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import THRESHOLDS, Threshold, ThresholdKind, records_needed
from hydrofdi.settings.quantities import SI, Section


class ChartConfig(Section):
    """A control chart on scores: the rule."""

    chart: Literal["cusum", "ewma", "glr"] = "cusum"
    """The rule."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the rule, which may also be given next to the other keys."""


_Confident = Annotated[float, SI("1", least=0.5, most=0.9999)]


class Promise(Section):
    """The false-alarm rate of a threshold."""

    false_alarm_rate: Annotated[float, SI("1", least=1e-9, most=0.5)] = 0.01
    """Fraction of healthy records, or of windows of a detector, that raise an alarm [-]."""

    confidence: _Confident = 0.95
    """Confidence of intervals and bounds [-]."""

    threshold: ThresholdKind = "quantile"
    """``quantile``: meets the rate on average. ``tolerance``: meets it with ``confidence``. ``tail``: a
    generalised Pareto model of the largest scores, for rates of 0.1 % and less."""

    def set_threshold(self, healthy: ArrayLike, direction: Direction) -> Threshold:
        """Set a threshold from healthy fit scores, shape (n_record,)."""
        method = THRESHOLDS[self.threshold]
        return method(healthy, self.false_alarm_rate, direction=direction, confidence=self.confidence)


class Rules(Promise):
    """Requirements on the detectors of a study, and confidence levels."""

    probability: _Confident = 0.9
    """Probability with which a leak should be found: 90 % gives q90 and, with the confidence, q90/95 [-]."""

    def records_for_threshold(self, direction: Direction) -> int:
        """Number of healthy fit records that a threshold in this direction needs; 0 if one is enough."""
        try:
            self.set_threshold([0.0], direction)
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
