"""Distance of a record from the region of healthy records, of any shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.detectors.scores.contract import FROM_HEALTHY, Flags, Rule, Score
from hydrofdi.detectors.scores.features import Whitening, require_shape, scikit_learn, whitening
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import SI, Section


class OneClassOptions(Section):
    """Options of `OneClass`."""

    outside: Annotated[float, Field(gt=0, lt=1)] = 0.1
    """Largest fraction ν of the fit records outside the boundary."""

    width: Annotated[float, SI("1", above=0)] = 1.0
    """Width of the kernel, in RMS distances of healthy records from their mean."""


@dataclass(frozen=True, eq=False)
class Outside:
    """Distance from the boundary of a one-class support vector machine after whitening, positive outside.

    Attributes
    ----------
    white : Whitening
    vectors : ndarray, shape (n_vector, n_kept)
        Whitened support vectors.
    weights : ndarray, shape (n_vector,)
        Their coefficients α.
    gamma, offset : float
        1/(2 n b²), and ρ.
    """

    white: Whitening
    vectors: Array
    weights: Array
    gamma: float
    offset: float

    def __post_init__(self) -> None:
        """Check the shapes."""
        require_shape(self.vectors, self.weights.size, self.white.mean.size)
        require_shape(self.weights, self.weights.size)

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,); each record by itself."""
        squared = (np.sum(np.square(self.vectors - row), axis=1) for row in self.white(values))
        near = [np.sum(self.weights * np.exp(-self.gamma * each)) for each in squared]
        return self.offset - np.array(near, dtype=float)


class OneClass(Score[OneClassOptions]):
    """One-class support vector machine on healthy records, with a Gaussian kernel on whitened features."""

    name = "one_class"
    summary = "One-class support vector machine around healthy records, on whitened features."
    source = "Schölkopf et al., Neural Computation 13 (2001) 1443"
    equation = "ρ − Σᵢ αᵢ exp(−‖w − wᵢ‖²/(2 n b²)), w = C^(−1/2) (z − m), n features, b the width"
    caution = (
        f"{FROM_HEALTHY} Records far away all have the score ρ: they raise alarms but cannot be ranked. The"
        " time of a fit grows with the square of the number of records."
    )
    needs_faulty = False
    Trained = Outside
    Options = OneClassOptions

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Whiten by healthy records, then train the support vector machine."""
        white = whitening(values, self.name)
        points = white(values)
        gamma = 0.5 / (points.shape[1] * self.options.width**2)
        with scikit_learn(self.name):
            from sklearn.svm import OneClassSVM

            machine = OneClassSVM(kernel="rbf", gamma=gamma, nu=self.options.outside).fit(points)
        weights = machine.dual_coef_[0]
        return Outside(white, machine.support_vectors_, weights, gamma, float(machine.offset_[0]))
