"""Detector from one indicator output."""

from __future__ import annotations

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.healthy_scale import HealthyScale, healthy_scale
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction, suspicion
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.counting import counted


class IndicatorDetector:
    """Deviation of an output from its healthy median, in healthy spreads, in the direction of a leak.

    Parameters
    ----------
    feature : Feature
    direction : Direction, optional
        Direction of an alarm; by default that of the output.

    Raises
    ------
    ConfigError
        No direction is given, and the output does not declare one.
    """

    def __init__(self, feature: Feature, direction: Direction | None = None) -> None:
        self.feature = feature
        self.direction = feature.direction(direction)

    def fit(self, healthy: RecordBatch) -> HealthyScale:
        """Fit median and spread to healthy records.

        Raises
        ------
        NotStatedError
            Too few records have a value, or it does not vary.
        """
        return healthy_scale(self._single(self.feature.of_healthy(healthy)))

    def score(self, model: HealthyScale, records: RecordBatch) -> Array:
        """Scores (n_record,) in healthy spreads; larger means a larger leak, NaN if there is no value."""
        return suspicion(model(self._single(self.feature.of(records))), self.direction)

    def _single(self, numbers: Array) -> Array:
        if numbers.shape[1] != 1:
            raise ConfigError(
                f"{self.feature.label} has {counted(numbers.shape[1], 'value')},"
                " but a single number is needed"
            )
        return np.asarray(numbers[:, 0])
