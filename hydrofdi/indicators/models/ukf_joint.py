"""Internal leakage as a state of an unscented Kalman filter."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.estimation.ekf_stream import Tuning
from hydrofdi.indicators.estimation.plant import STATES
from hydrofdi.indicators.estimation.ukf_stream import Estimated, Streams, Workspace, follow_unscented
from hydrofdi.indicators.models.ekf_joint import EkfJoint, JointOptions
from hydrofdi.indicators.recursive import State
from hydrofdi.records import Array, RecordBatch
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

    def begin(self, records: RecordBatch) -> State:
        """State of the filters before the first sample."""
        return Streams.of(records.n_record, self.options.places.size)._asdict()

    def follow(
        self, state: dict[str, NDArray[Any]], n_before: int, samples: tuple[Array, Array, Array],
        tuning: Tuning, every: int, found: tuple[Array, Array, Array],
    ) -> None:  # fmt: skip
        """Advance the filters in place, and fill means, variances and sums at the instants that are due."""
        places = self.options.places
        streams = Streams(**{name: state[name] for name in Streams._fields})
        estimated = Estimated(places, np.sqrt(tuning.walk[places]), self.options.spread)
        work = Workspace.of(places.size, self.options.substeps)
        follow_unscented(streams, n_before, *samples, tuning, every, *found, estimated, work)
