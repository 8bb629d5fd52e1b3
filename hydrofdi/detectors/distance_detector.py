"""Detector from several indicator outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hydrofdi.detectors.features import Feature, features_of
from hydrofdi.errors import ConfigError
from hydrofdi.records import Array, RecordBatch
from hydrofdi.scoring import Fitted, make_score
from hydrofdi.scoring.contract import Score


class DistanceDetector:
    """Distance of records from healthy ones in several outputs: Mahalanobis with shrinkage covariance.

    Parameters
    ----------
    features : sequence of Feature
        Outputs to use; of array outputs, all elements.
    score : Score, optional
        Another score that is trained on healthy records.

    Raises
    ------
    ConfigError
        The score requires faulty records for training.
    """

    def __init__(self, features: Sequence[Feature], score: Score[Any] | None = None) -> None:
        self.features = tuple(features)
        self.distance = score or make_score("mahalanobis")
        if self.distance.needs_faulty:
            raise ConfigError(
                f"the score {self.distance.name} requires faulty records for training,"
                " but a detector has only healthy ones"
            )

    def fit(self, healthy: RecordBatch) -> Fitted:
        """Fit centre and covariance to healthy records.

        Raises
        ------
        NotStatedError
            Too few records have all values.
        """
        numbers = np.hstack([feature.of_healthy(healthy) for feature in self.features])
        return self.distance.fit(numbers, np.zeros(len(numbers), dtype=bool))

    def score(self, model: Fitted, records: RecordBatch) -> Array:
        """Scores (n_record,); larger scores mean larger leaks, NaN if a record lacks a value."""
        return model.score(features_of(self.features, records))
