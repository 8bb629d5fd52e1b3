"""Known parameters of a Kalman filter, and the path of its spool."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.estimation.plant import STATES, Plant, between_samples, follow_command
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

Places = NDArray[np.int64]

N_MEASURED = 3
"""Number of measurements: P_1, P_2 and x_p, the first of the states."""

FIRST_PARAMETER = STATES.index("leakage")
"""Index of the first state that is neither motion nor force."""


class Tuning(NamedTuple):
    """Known parameters of plant and sensors.

    `step` of Runge-Kutta [s]; `spool_transition` (2, 2) over half a step; whether the spool `follows_command`
    or is measured; initial variance `prior` and process noise `walk` per sample of each estimated state, of
    an unscented filter their roots; variances of the `sensors` [MPa², MPa², mm²]; `limits` of each estimate;
    `places`: indices of the estimated states in ``STATES``, moving states first; all other states are zero.
    Parameters are not updated while the spool is within `null_zone` of its centre, or travels more than
    `largest_travel` within a sample [mm].
    """

    plant: Plant
    step: float
    spool_transition: Array
    follows_command: bool
    prior: Array
    walk: Array
    sensors: Array
    limits: Array
    places: Places
    null_zone: float
    largest_travel: float

    def of_roots(self, places: Places) -> Tuning:
        """For an unscented filter of some states."""
        prior, walk = np.sqrt(self.prior[places]), np.sqrt(self.walk[places])
        return self._replace(prior=prior, walk=walk, limits=self.limits[places], places=places)


@equation
def find_path(spool: Array, before: float, drive: float, tuning: Tuning, path: Array) -> bool:
    """Fill the path of a spool to the next sample; return whether the valve stays open and nearly at rest."""
    if tuning.follows_command:
        follow_command(spool, before, tuning.spool_transition, path)
    else:
        between_samples(before, drive, path)
    least, most = min(path[0], path[-1]), max(path[0], path[-1])
    is_open: bool = least > tuning.null_zone or most < -tuning.null_zone
    return is_open and most - least <= tuning.largest_travel
