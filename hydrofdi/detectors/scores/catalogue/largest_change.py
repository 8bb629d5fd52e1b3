"""Largest relative fall of a feature: the rule of the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.detectors.scores.contract import Flags, Rule, Score
from hydrofdi.detectors.scores.features import require_shape
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section


@dataclass(frozen=True, eq=False)
class LargestFall:
    """Largest fall below `means`, shape (n_feature,), relative to them."""

    means: Array

    def __post_init__(self) -> None:
        """Check the shape."""
        require_shape(self.means, self.means.size)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return np.asarray(np.max((self.means - values) / self.means, axis=1))


class LargestChange(Score[Section]):
    """Largest relative fall of a feature below its healthy mean.

    It scales features by their means, so it depends on their zero points, unlike the other scores.
    """

    name = "largest_change"
    summary = "Largest fall of a feature below its healthy mean, relative to the mean."
    source = "Maddahi, Yazdanpanah Goharrizi, Wu and Sepehri, CDSR 2015, paper 181"
    equation = "max_j (m_j − y_j)/m_j, m the means of healthy records"
    caution = "The feature that varies most without a fault dominates: a change is scaled only by the mean."
    needs_faulty = False
    needs_extra = False
    Trained = LargestFall

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Fit the means of healthy records."""
        means = values.mean(axis=0)
        if not means.all():
            raise NotStatedError("the score largest_change: a feature has zero mean in healthy records")
        return LargestFall(means)
