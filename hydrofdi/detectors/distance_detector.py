"""Several numbers of indicators as a detector."""

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
    """How far records lie from healthy ones in several numbers: Mahalanobis with a shrunk covariance.

    Parameters
    ----------
    features : sequence of Feature
        All numbers of each count.
    score : Score, optional
        Another score that learns from healthy records.

    Raises
    ------
    ConfigError
        The score learns from faulty records.
    """

    def __init__(self, features: Sequence[Feature], score: Score[Any] | None = None) -> None:
        self.features = tuple(features)
        self.distance = score or make_score("mahalanobis")
        if self.distance.needs_faulty:
            raise ConfigError(
                f"the score {self.distance.name} learns from faulty records, which a detector does not have"
            )

    def fit(self, healthy: RecordBatch) -> Fitted:
        """Centre and covariance of healthy records.

        Raises
        ------
        NotStatedError
            Too few of them have all numbers.
        """
        numbers = np.hstack([feature.of_healthy(healthy) for feature in self.features])
        return self.distance.fit(numbers, np.zeros(len(numbers), dtype=bool))

    def score(self, model: Fitted, records: RecordBatch) -> Array:
        """Scores (n_record,): larger is leakier. NaN if a record lacks a number."""
        return model.score(features_of(self.features, records))
