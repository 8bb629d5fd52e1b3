"""How much a record loses out of its chambers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics.leakage import external_leakage_flow
from hydrofdi.simulation import Trajectory


def mean_external_leakage_flows(
    runs: Sequence[RunParameters], trajectory: Trajectory
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean of q_el1 and q_el2 over the samples [m³/s], each of shape (n_run,)."""
    pressures = (trajectory.chamber_1_pressure, trajectory.chamber_2_pressure)
    coefficients = (
        np.array([run.leakage.chamber_1_coefficient for run in runs]),
        np.array([run.leakage.chamber_2_coefficient for run in runs]),
    )
    first, second = (
        np.asarray(external_leakage_flow(np.mean(pressure, axis=1), coefficient))
        for pressure, coefficient in zip(pressures, coefficients, strict=True)
    )
    return first, second
