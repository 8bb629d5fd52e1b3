"""Position control of the lanes: each has its own sampled controller and spool."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.physics.control import converted, pid_step
from hydrofdi.physics.equation import equation
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH
from hydrofdi.simulation.kernels.options import ModelOptions
from hydrofdi.simulation.kernels.spool import move_spool


@equation
def control(half: Any, k: int, references: NDArray[np.float64], column: int, options: ModelOptions) -> None:
    """Sample the controller of a lane: read the piston position and set the voltage."""
    position = half.position[k]
    if options.measured_feedback is not None:
        position = converted(
            position + references[1, column], half.lowest_reading[k], half.highest_reading[k],
            half.reading_resolution[k],
        )  # fmt: skip
    error = references[0, column] - position
    voltage, integral = pid_step(
        error, half.error[k], half.integral[k],
        half.proportional_gain[k], half.integral_gain[k], half.derivative_gain[k],
        half.sample_time[k], half.voltage_limit[k],
    )  # fmt: skip
    half.voltage[k], half.integral[k], half.error[k] = voltage, integral, error


@equation
def steer(
    left: Any,
    right: Any,
    references: NDArray[np.float64],
    columns: NDArray[np.int64],
    step: float,
    is_due: bool,
    options: ModelOptions,
) -> None:
    """Sample the controllers if due, and advance the spools of all lanes by one step.

    Parameters
    ----------
    left, right : record
        The halves of the lanes.
    references : ndarray, shape (2, n_reference)
        Position references at this step, and errors of the measured position [m].
    columns : ndarray, shape (WIDTH,)
        Column of each lane.
    step : float
        h [s].
    is_due : bool
    options : ModelOptions
    """
    if is_due:
        for k in range(HALF_WIDTH):
            control(left, k, references, columns[k], options)
            control(right, k, references, columns[HALF_WIDTH + k], options)
    for k in range(HALF_WIDTH):
        move_spool(left, k, step, options.limited_spool, options.hysteresis)
        move_spool(right, k, step, options.limited_spool, options.hysteresis)
