"""Compiled kernel: classic Runge-Kutta integration of many runs in parallel lanes.

The spool does not depend on the hydraulics. In open loop it is integrated once for all runs with the same
drive, and its positions at the four stages of every step are passed to the lanes; the result equals a joint
integration. In closed loop each lane has its own spool, which is advanced before the hydraulics within each
step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.physics.control import converted, pid_step
from hydrofdi.physics.equation import equation, settled
from hydrofdi.simulation.kernels.hydraulics import LaneParameters, State, hydraulic_rates, lane_parameters
from hydrofdi.simulation.kernels.lanes import HALF_WIDTH, LINES, OPTIONAL, SAMPLED, STATES, ModelOptions
from hydrofdi.simulation.kernels.spool import move_spool


@equation
def control(half: Any, k: int, references: NDArray[np.float64], column: int, options: ModelOptions) -> None:
    """Sample the controller of a lane: read the piston position and set the voltage."""
    position = half.position[k]
    if options.measured_feedback is not None:
        position = converted(
            half.reading_gain[k] * position + references[1, column],
            half.lowest_reading[k], half.highest_reading[k], half.reading_resolution[k],
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
    """
    if is_due:
        for k in range(HALF_WIDTH):
            control(left, k, references, columns[k], options)
            control(right, k, references, columns[HALF_WIDTH + k], options)
    for k in range(HALF_WIDTH):
        move_spool(left, k, step, options.limited_spool, options.hysteresis)
        move_spool(right, k, step, options.limited_spool, options.hysteresis)


@equation
def supported(pressure: float, p: LaneParameters, options: ModelOptions) -> float:
    """Chamber pressure, or the vapour pressure if it is lower and the fluid boils [Pa]."""
    return pressure if options.clamped_cavitation is None else max(pressure, p.vapour_pressure)


def _moved(name: str) -> str:
    """Expression of a state after moving with constant rates for a time."""
    value = f"state.{name} + time * rates.{name}"
    if name in OPTIONAL:
        return f"state.{name} if options.{OPTIONAL[name]} is None else {value}"
    return f"supported({value}, p, options)" if name.startswith("pressure") else value


_MOVED = ", ".join(map(_moved, STATES))
_WEIGHTED = ", ".join(f"a.{name} + 2.0 * (b.{name} + c.{name}) + d.{name}" for name in STATES)
_OF_LANE = ", ".join(f"half.{name}[k]" for name in STATES)

moved = equation(eval(f"lambda state, time, rates, p, options: State({_MOVED})"))
"""State after moving with constant rates for a time [s]."""

weighted = equation(eval(f"lambda a, b, c, d: State({_WEIGHTED})"))
"""Six times the mean rates of classic Runge-Kutta: k1 + 2 k2 + 2 k3 + k4."""

state_of = equation(eval(f"lambda half, k: State({_OF_LANE})"))
"""State of a lane."""


@equation
def keep_state(half: Any, k: int, state: State, options: ModelOptions) -> None:
    """Write back the state of a lane, with negligible values set to zero."""
    half.position[k], half.velocity[k] = settled(state.position), settled(state.velocity)
    half.pressure_1[k], half.pressure_2[k] = settled(state.pressure_1), settled(state.pressure_2)
    if options.moving_supply is not None:
        half.supply[k] = settled(state.supply)
    if options.bristles is not None:
        half.bristle[k] = settled(state.bristle)
    if options.return_line is not None:
        half.return_pressure[k] = settled(state.return_pressure)
    if options.foundation is not None:
        half.support[k] = settled(state.support)
    if options.hoses is not None:
        half.line_pressure_1[k] = settled(state.line_pressure_1)
        half.line_pressure_2[k] = settled(state.line_pressure_2)
        half.line_flow_1[k], half.line_flow_2[k] = settled(state.line_flow_1), settled(state.line_flow_2)


_SUPPLY, _BRISTLE, _RETURN, _SUPPORT, _VOLTAGE, _SPOOL = map(
    SAMPLED.index, ("supply", "bristle", "return_pressure", "support", "voltage", "spool_position")
)
_LINE_1, _FLOW_1, _LINE_2, _FLOW_2 = map(SAMPLED.index, LINES)


@equation
def take_sample(half: Any, sample: NDArray[np.float64], first: int, options: ModelOptions) -> None:
    """Copy the sampled states of a half into its columns, in the order of ``lanes.SAMPLED``."""
    for k in range(HALF_WIDTH):
        sample[0, first + k] = half.position[k]
        sample[1, first + k] = half.velocity[k]
        sample[2, first + k] = half.pressure_1[k]
        sample[3, first + k] = half.pressure_2[k]
    if options.moving_supply is not None:
        take(half.supply, sample[_SUPPLY], first)
    if options.bristles is not None:
        take(half.bristle, sample[_BRISTLE], first)
    if options.return_line is not None:
        take(half.return_pressure, sample[_RETURN], first)
    if options.foundation is not None:
        take(half.support, sample[_SUPPORT], first)
    if options.hoses is not None:
        take(half.line_pressure_1, sample[_LINE_1], first)
        take(half.line_flow_1, sample[_FLOW_1], first)
        take(half.line_pressure_2, sample[_LINE_2], first)
        take(half.line_flow_2, sample[_FLOW_2], first)
    if options.closed_loop is not None:
        take(half.voltage, sample[_VOLTAGE], first)
        take(half.spool_1, sample[_SPOOL], first)


@equation
def take(values: NDArray[np.float64], row: NDArray[np.float64], first: int) -> None:
    """Copy the values of a half into the columns of a row."""
    for k in range(HALF_WIDTH):
        row[first + k] = values[k]


@equation
def take_spools(half: Any, stages: NDArray[np.float64], columns: NDArray[np.int64], first: int) -> None:
    """Copy the spool positions of a step to the lanes of a half, each from the column of its drive."""
    for k in range(HALF_WIDTH):
        column = columns[first + k]
        half.spool_1[k] = stages[0, column]
        half.spool_2[k] = stages[1, column]
        half.spool_3[k] = stages[2, column]
        half.spool_4[k] = stages[3, column]


@equation
def take_loads(half: Any, loads: NDArray[np.float64], columns: NDArray[np.int64], first: int) -> None:
    """Copy the load forces of a step to the lanes of a half."""
    for k in range(HALF_WIDTH):
        half.load[k] = loads[columns[first + k]]


@kernel
def advance_lanes(
    lanes: NDArray[Any],
    drive: NDArray[np.float64],
    drive_of_lane: NDArray[np.int64],
    loads: NDArray[np.float64],
    load_of_lane: NDArray[np.int64],
    step: float,
    steps_per_sample: int,
    steps_per_control: int,
    samples: NDArray[np.float64],
    first_step: int,
    options: ModelOptions,
) -> None:
    """Advance all lanes by the steps of `drive`, and sample them.

    Parameters
    ----------
    lanes : ndarray of LANES, shape (1,)
        Parameters and state; the state is updated in place.
    drive : ndarray, shape (n_step, n_stage, n_drive)
        In open loop the spool position at the four stages of each step, one column per drive [m]; in closed
        loop the position reference of each step, and the error of the measured position [m].
    drive_of_lane : ndarray, shape (WIDTH,)
        Column of each lane.
    loads : ndarray, shape (n_step, n_load)
        Load force of each step [N]; ignored without the option.
    load_of_lane : ndarray, shape (WIDTH,)
        Column of each lane.
    step : float
        Runge-Kutta step h [s].
    steps_per_sample : int
        Number of steps per sample; samples are taken at the start of a step, including the first.
    steps_per_control : int
        Number of steps per sample of the controllers in closed loop, counted from the start of the record.
    samples : ndarray, shape (n_step / steps_per_sample, n_row, WIDTH)
        Filled with the rows of ``lanes.SAMPLED`` that the options require.
    first_step : int
        Number of the first step, counted from the start of the record.
    options : ModelOptions
        Options shared by all lanes.
    """
    left, right = lanes[0].left, lanes[0].right
    half_step, sixth_step = 0.5 * step, step / 6.0
    first, share_drive = drive_of_lane[0], True
    for k in range(1, 2 * HALF_WIDTH):
        share_drive &= drive_of_lane[k] == first
    for i in range(drive.shape[0]):
        stages = drive[i]
        time = (first_step + i) * step
        if options.closed_loop is not None:
            is_due = (first_step + i) % steps_per_control == 0
            steer(left, right, stages, drive_of_lane, step, is_due, options)
        elif share_drive:
            stage_1, stage_2 = stages[0, first], stages[1, first]
            stage_3, stage_4 = stages[2, first], stages[3, first]
            for k in range(HALF_WIDTH):
                left.spool_1[k] = right.spool_1[k] = stage_1
                left.spool_2[k] = right.spool_2[k] = stage_2
                left.spool_3[k] = right.spool_3[k] = stage_3
                left.spool_4[k] = right.spool_4[k] = stage_4
        else:
            take_spools(left, stages, drive_of_lane, 0)
            take_spools(right, stages, drive_of_lane, HALF_WIDTH)
        if options.load_force is not None:
            take_loads(left, loads[i], load_of_lane, 0)
            take_loads(right, loads[i], load_of_lane, HALF_WIDTH)
        if i % steps_per_sample == 0:
            sample = samples[i // steps_per_sample]
            take_sample(left, sample, 0, options)
            take_sample(right, sample, HALF_WIDTH, options)
        # Two independent lanes in one loop body hide each other's latencies.
        for k in range(HALF_WIDTH):
            p = lane_parameters(left, k, time, time + half_step, options)
            q = lane_parameters(right, k, time, time + half_step, options)
            f, g = left.load[k], right.load[k]
            y, z = state_of(left, k), state_of(right, k)
            y1 = hydraulic_rates(y, left.spool_1[k], f, p, options)
            z1 = hydraulic_rates(z, right.spool_1[k], g, q, options)
            y2 = hydraulic_rates(moved(y, half_step, y1, p, options), left.spool_2[k], f, p, options)
            z2 = hydraulic_rates(moved(z, half_step, z1, q, options), right.spool_2[k], g, q, options)
            y3 = hydraulic_rates(moved(y, half_step, y2, p, options), left.spool_3[k], f, p, options)
            z3 = hydraulic_rates(moved(z, half_step, z2, q, options), right.spool_3[k], g, q, options)
            y4 = hydraulic_rates(moved(y, step, y3, p, options), left.spool_4[k], f, p, options)
            z4 = hydraulic_rates(moved(z, step, z3, q, options), right.spool_4[k], g, q, options)
            keep_state(left, k, moved(y, sixth_step, weighted(y1, y2, y3, y4), p, options), options)
            keep_state(right, k, moved(z, sixth_step, weighted(z1, z2, z3, z4), q, options), options)
