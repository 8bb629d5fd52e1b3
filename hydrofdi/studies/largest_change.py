"""The feature that fell most: the rule of the paper for details of the wavelet transform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hydrofdi.evaluation.refusal import NotStatedError
from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.contract import Flags, Rule, Score
from hydrofdi.settings.quantities import Section


class LargestChange(Score[Section]):
    """The largest positive sensitivity: the largest fall of a feature below its healthy mean.

    It weighs features by their means, so it depends on their zeros, unlike the scores of `hydrofdi.scoring`.
    """

    name = "largest_change"
    summary = "Largest fall of a number below its healthy mean, as a share of the mean."
    source = "Maddahi, Yazdanpanah Goharrizi, Wu and Sepehri, CDSR 2015, paper 181"
    equation = "max_j (m_j − y_j)/m_j, m the means of healthy records"
    caution = "The number that varies most without a fault decides: a change is weighed by the mean alone."
    needs_faulty = False

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Means of healthy records."""
        means = values.mean(axis=0)
        if not means.all():
            raise NotStatedError("the score largest_change: a number is zero on average in healthy records")
        return LargestFall(means)


@dataclass(frozen=True, eq=False)
class LargestFall:
    """The largest fall below `means`, shape (n_feature,), as a share of them."""

    means: Array

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return np.asarray(np.max((self.means - values) / self.means, axis=1))
