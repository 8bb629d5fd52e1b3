"""Internal leakage as a state of an unscented Kalman filter."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.estimation import ukf
from hydrofdi.indicators.estimation.plant import STATES
from hydrofdi.indicators.estimation.tuning import Tuning
from hydrofdi.indicators.models.ekf_joint import EkfJoint, JointOptions
from hydrofdi.records import RecordBatch
from hydrofdi.settings.quantities import SI


class UnscentedOptions(JointOptions):
    """Options of `UkfJoint`."""

    spread: Annotated[float, SI("1", above=0, most=1)] = 1.0
    """Spread α of the sigma points about the mean, in √n standard deviations for n states [-]; with 0.001 it
    is nearly an extended filter."""

    @property
    def places(self) -> NDArray[np.int64]:
        """Indices of the estimated states in ``STATES``."""
        return np.array([place for place, name in enumerate(STATES) if name in self.estimated])


class UkfJoint(EkfJoint):
    """Internal leakage, bulk modulus and valve parameters as states of a square-root unscented Kalman
    filter.
    """

    name = "ukf_joint"
    version = 3
    source = (
        "van der Merwe & Wan, ICASSP (2001); leakage: Sepasi & Sassani, IJCAS 8 (2010); Liu, Proc. Inst."
        " Mech. Eng. I 228 (2014)"
    )
    equation = "states and measurements of ekf_joint; mean and covariance from 2n + 1 points, P = S Sᵀ"
    Options = UnscentedOptions
    options: UnscentedOptions

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the state of a filter: the root of the covariance of the estimated states."""
        n = self.options.places.size
        return {"mean": (n,), "root": (n, n), "sums": (1,), "spool": (2,), "held": (2,)}

    def tuning(self, records: RecordBatch) -> Tuning:
        """Known parameters of the estimated states; standard deviations in place of variances."""
        return super().tuning(records).of_roots(self.options.places)

    def spread_and_workspace(self) -> tuple[float | None, Any]:
        """Spread of the sigma points, and scratch arrays."""
        return self.options.spread, ukf.workspace(self.options.places.size, self.options.substeps)
