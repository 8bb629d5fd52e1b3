"""Mahalanobis distance of a record from healthy records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.detectors.scores.contract import FROM_HEALTHY, Flags, Rule, Score
from hydrofdi.detectors.scores.features import Whitening, whitening
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import Section


class MahalanobisOptions(Section):
    """Options of `Mahalanobis`."""

    shrinkage: Annotated[float, Field(ge=0, le=1)] | None = None
    """Weight δ of the identity matrix in the covariance; by default chosen by cross-validation on the fit
    records."""


@dataclass(frozen=True, eq=False)
class SquaredDistance:
    """Squared distance from the mean after whitening."""

    white: Whitening

    def __call__(self, values: Array) -> Array:
        """Scores, shape (n_record,)."""
        return np.asarray(np.sum(np.square(self.white(values)), axis=1))


class Mahalanobis(Score[MahalanobisOptions]):
    """Squared Mahalanobis distance from the mean of healthy records."""

    name = "mahalanobis"
    summary = "Squared Mahalanobis distance from healthy records, with a shrunk covariance."
    source = (
        "Mahalanobis, Proc. Natl. Inst. Sci. India 2 (1936) 49;"
        " Hoffbeck and Landgrebe, IEEE Trans. Pattern Anal. Mach. Intell. 18 (1996) 763"
    )
    equation = "(z − m)ᵀ C⁻¹ (z − m), C = (1 − δ) S + δ tr(S)/n I"
    caution = FROM_HEALTHY
    needs_faulty = False
    Trained = SquaredDistance
    Options = MahalanobisOptions

    def learn(self, values: Array, is_faulty: Flags) -> Rule:
        """Fit mean and covariance of healthy records."""
        return SquaredDistance(whitening(values, self.name, self.options.shrinkage))
