"""Internal leakage flow over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.simulation.kernels.hydraulics import lane_parameters, leakage_of
from hydrofdi.simulation.kernels.lanes import pack_singles
from hydrofdi.simulation.kernels.options import group_by_options


def leakage_signal(
    runs: Sequence[RunParameters],
    leakage_coefficients: Sequence[float],
    time: NDArray[np.float64],
    pressure_difference: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Internal leakage flow of runs, each with its own law and onset.

    Parameters
    ----------
    runs : sequence of RunParameters
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].
    time : ndarray, shape (n_time,)
        Sampling instants [s].
    pressure_difference : ndarray, shape (n_run, n_time)
        P_1 − P_2 [Pa].

    Returns
    -------
    ndarray, shape (n_run, n_time)
        q_il from chamber 1 to chamber 2 [m³/s].
    """
    singles = pack_singles(runs, leakage_coefficients)
    flow = np.empty_like(pressure_difference)
    for options, members in group_by_options(runs):
        columns = singles[members].view(np.recarray)
        parameters = lane_parameters(columns, ..., time, options)
        flow[members] = leakage_of(pressure_difference[members], parameters, options)
    return flow
