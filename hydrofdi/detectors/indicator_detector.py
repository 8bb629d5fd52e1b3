"""One number of an indicator as a detector."""

from __future__ import annotations

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.healthy_scale import HealthyScale, healthy_scale
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction, suspicion
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.counting import counted


class IndicatorDetector:
    """How far a number lies from its healthy median, in healthy spreads, in the direction of a leak.

    Parameters
    ----------
    feature : Feature
    direction : Direction, optional
        That of the output where none is given.

    Raises
    ------
    ConfigError
        The output has no direction of its own, and none is given.
    """

    def __init__(self, feature: Feature, direction: Direction | None = None) -> None:
        self.feature = feature
        self.direction = feature.direction(direction)

    def fit(self, healthy: RecordBatch) -> HealthyScale:
        """Median and spread of healthy records.

        Raises
        ------
        NotStatedError
            Too few of them have the number, or it does not vary.
        """
        return healthy_scale(self._single(self.feature.of_healthy(healthy)))

    def score(self, model: HealthyScale, records: RecordBatch) -> Array:
        """Scores (n_record,) in healthy spreads: larger is leakier. NaN if a record has no number."""
        return suspicion(model(self._single(self.feature.of(records))), self.direction)

    def _single(self, numbers: Array) -> Array:
        if numbers.shape[1] != 1:
            raise ConfigError(
                f"{self.feature.label} has {counted(numbers.shape[1], 'number')}, and one is needed"
            )
        return np.asarray(numbers[:, 0])
