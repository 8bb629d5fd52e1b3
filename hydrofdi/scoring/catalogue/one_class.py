"""Distance of a record from the region of healthy records, of any shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from hydrofdi.evaluation.scores import Array
from hydrofdi.scoring.contract import FROM_HEALTHY, Flags, Rule, Score
from hydrofdi.scoring.features import Whitening, scikit_learn, whitening
from hydrofdi.settings.quantities import SI, Section


class OneClassOptions(Section):
    """Options of `OneClass`."""

    outside: Annotated[float, Field(gt=0, lt=1)] = 0.1
    """Largest fraction ν of the fit records outside the boundary."""

    width: Annotated[float, SI("1", above=0)] = 1.0
    """Width of the kernel, in RMS distances of healthy records from their mean."""


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
    Options = OneClassOptions

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Whiten by healthy records, then train the support vector machine."""
        white = whitening(values, self.name)
        points = white(values)
        gamma = 0.5 / (points.shape[1] * self.options.width**2)
        with scikit_learn(self.name):
            from sklearn.svm import OneClassSVM

            machine = OneClassSVM(kernel="rbf", gamma=gamma, nu=self.options.outside).fit(points)
        return Outside(white, machine)


@dataclass(frozen=True, eq=False)
class Outside:
    """Distance from the boundary of a one-class support vector machine after whitening, positive outside."""

    white: Whitening
    machine: Any

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        if not values.size:
            return np.empty(0)
        return -np.asarray(self.machine.decision_function(self.white(values)))
