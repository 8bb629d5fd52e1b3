"""Kernel: classic Runge-Kutta integration of many runs in parallel lanes.

A spool does not depend on the hydraulics, so within a step it is advanced before them. In open loop it is
integrated once for all runs with the same drive, and its positions at the four stages of every step are
passed to the lanes; the result equals a joint integration. In closed loop each lane has its own spool.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import recorded_kernel
from hydrofdi.compilation.symbols import each, when, when_else
from hydrofdi.physics import NEGLIGIBLE, Quantity, limited
from hydrofdi.physics.valve import acting_voltage, converted, pid_step, spool_acceleration
from hydrofdi.simulation.hydraulics import State, hydraulic_rates, lane_parameters
from hydrofdi.simulation.lanes import HALF_WIDTH, OPTIONAL, SAMPLED, STATES, WIDTH, ModelOptions

SPOOL_STAGES = ("spool_1", "spool_2", "spool_3", "spool_4")
"""Lane fields of the spool position at the four stages of a step."""


# `physics.settled` for symbols, which have no branches; numba would make an array of this one.
def settled(value: Quantity) -> Quantity:
    """The state, or zero if it is negligible; NaN stays NaN."""
    return np.where(np.abs(value) < NEGLIGIBLE, 0.0, value)


def spool_rates(
    position: float,
    velocity: float,
    voltage: float,
    frequency: float,
    damping_ratio: float,
    gain: float,
    position_limit: float,
    speed_limit: float,
    is_limited: bool,
) -> tuple[float, float]:
    """x_v' [m/s] and v_v' [m/s²]; with limits, command and speed saturate."""
    if is_limited:
        # (4a): in volts, the limit is the input at which the spool rests at its largest opening.
        command = limited(voltage, position_limit / gain)
        return (
            limited(velocity, speed_limit),
            spool_acceleration(position, velocity, command, frequency, damping_ratio, gain),
        )
    return velocity, spool_acceleration(position, velocity, voltage, frequency, damping_ratio, gain)


def valve_opening(position: float, position_limit: float, is_limited: bool) -> float:
    """Spool position that acts on the ports, after saturation [m]."""
    if is_limited:
        # (4a): an underdamped spool may pass the limit, but the ports open no further.
        opening: float = limited(position, position_limit)
        return opening
    return position


def move_spool(spools: Any, k: int, step: float, is_limited: bool, has_hysteresis: bool) -> None:
    """Advance spool `k` of a record by one step, and store its openings at the four stages."""
    u = spools.voltage[k]
    if has_hysteresis:
        # (4b): once per step is enough, as the input is held over it.
        u = spools.acting_voltage[k] = acting_voltage(u, spools.acting_voltage[k], spools.hysteresis[k])
    w, xi, k_v = (spools.spool_frequency[k], spools.spool_damping_ratio[k], spools.spool_gain[k])
    most, fastest = spools.spool_limit[k], spools.spool_speed_limit[k]
    x, v = spools.spool_position[k], spools.spool_velocity[k]
    # Classic Runge-Kutta of (3) and (4); the lanes need the positions of all four stages.
    half_step, sixth_step = 0.5 * step, step / 6.0
    r1, a1 = spool_rates(x, v, u, w, xi, k_v, most, fastest, is_limited)
    x2, v2 = x + half_step * r1, v + half_step * a1
    r2, a2 = spool_rates(x2, v2, u, w, xi, k_v, most, fastest, is_limited)
    x3, v3 = x + half_step * r2, v + half_step * a2
    r3, a3 = spool_rates(x3, v3, u, w, xi, k_v, most, fastest, is_limited)
    x4, v4 = x + step * r3, v + step * a3
    r4, a4 = spool_rates(x4, v4, u, w, xi, k_v, most, fastest, is_limited)
    for name, position in zip(SPOOL_STAGES, (x, x2, x3, x4), strict=True):
        getattr(spools, name)[k] = valve_opening(position, most, is_limited)
    # Zero instead of subnormal numbers, in which a spool at rest would end.
    spools.spool_position[k] = settled(x + sixth_step * (r1 + 2.0 * (r2 + r3) + r4))
    spools.spool_velocity[k] = settled(v + sixth_step * (a1 + 2.0 * (a2 + a3) + a4))


@recorded_kernel
def advance_spools(
    spools: NDArray[Any],
    voltage: NDArray[np.float64],
    step: float,
    first_drive: int,
    n_drive: int,
    stages: NDArray[np.float64],
    is_limited: bool,
    has_hysteresis: bool,
) -> None:
    """Integrate a record of spools, and store their openings at the stages of each step.

    Parameters
    ----------
    spools : ndarray of SPOOLS, shape (1,)
        Parameters and state; the state is updated in place.
    voltage : ndarray, shape (n_step, n_column)
        Input, held over each step [V].
    step : float
        Runge-Kutta step h [s].
    first_drive, n_drive : int
        Column of the first of these spools, and their number; unused spools of the record stay at 0 V.
    stages : ndarray, shape (n_step, 4, n_column)
        Filled with spool positions [m], in n_drive columns.
    is_limited : bool
        Whether position or speed of any spool saturates.
    has_hysteresis : bool
        Whether any spool has hysteresis.
    """
    spool = spools[0]
    for i in each(voltage.shape[0]):
        for k in each(n_drive):
            spool.voltage[k] = voltage[i, first_drive + k]
        # The full width, so that every spool has the same vector instructions; those not used rest at 0 V.
        for k in each(WIDTH):
            move_spool(spool, k, step, is_limited, has_hysteresis)
        for k in each(n_drive):
            for stage, name in enumerate(SPOOL_STAGES):
                stages[i, stage, first_drive + k] = getattr(spool, name)[k]


def control(half: Any, k: int, references: NDArray[np.float64], column: int, options: ModelOptions) -> None:
    """Sample the controller of a lane: read the piston position and set the voltage."""
    position = half.position[k]
    if options.measured_feedback:
        # (m4), whose errors come in with the references, then (m5) and (m6).
        position = converted(
            half.reading_gain[k] * position + references[1, column],
            half.lowest_reading[k], half.highest_reading[k], half.reading_resolution[k],
        )  # fmt: skip
    error = references[0, column] - position
    voltage, integral = pid_step(  # (c1)
        error, half.error[k], half.integral[k],
        half.proportional_gain[k], half.integral_gain[k], half.derivative_gain[k],
        half.sample_time[k], half.voltage_limit[k],
    )  # fmt: skip
    half.voltage[k], half.integral[k], half.error[k] = voltage, integral, error


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
    with when(is_due):
        for k in each(HALF_WIDTH):
            control(left, k, references, columns[k], options)
            control(right, k, references, columns[HALF_WIDTH + k], options)
    for k in each(HALF_WIDTH):
        move_spool(left, k, step, options.limited_spool, options.hysteresis)
        move_spool(right, k, step, options.limited_spool, options.hysteresis)


def moved(state: State, time: float, rates: State, options: ModelOptions) -> State:
    """State after moving with constant rates for a time [s]."""
    values = {name: getattr(state, name) for name in STATES}
    for name in _moving(options):
        values[name] = values[name] + time * getattr(rates, name)
    return State(**values)


def _moving(options: ModelOptions) -> list[str]:
    """States that are not constant."""
    return [name for name in STATES if name not in OPTIONAL or getattr(options, OPTIONAL[name])]


def weighted(a: State, b: State, c: State, d: State) -> State:
    """Six times the mean rates of classic Runge-Kutta: k1 + 2 k2 + 2 k3 + k4."""
    return State(*(e + 2.0 * (f + g) + h for e, f, g, h in zip(a, b, c, d, strict=True)))


def state_of(half: Any, k: int) -> State:
    """State of a lane."""
    return State(*(getattr(half, name)[k] for name in STATES))


def keep_state(half: Any, k: int, state: State, options: ModelOptions) -> None:
    """Write back the state of a lane, with negligible values set to zero."""
    for name in _moving(options):
        getattr(half, name)[k] = settled(getattr(state, name))


def take_sample(half: Any, sample: NDArray[np.float64], first: int, options: ModelOptions) -> None:
    """Copy the sampled states of a half into its columns, in the order of ``lanes.SAMPLED``."""
    taken = {name: name for name in _moving(options)}
    if options.closed_loop:
        taken |= {"voltage": "voltage", "spool_position": "spool_1"}
    for name, field in taken.items():
        for k in each(HALF_WIDTH):
            sample[SAMPLED.index(name), first + k] = getattr(half, field)[k]


def take_spools(half: Any, stages: NDArray[np.float64], columns: NDArray[np.int64], first: int) -> None:
    """Copy the spool positions of a step to the lanes of a half, each from the column of its drive."""
    for k in each(HALF_WIDTH):
        for stage, name in enumerate(SPOOL_STAGES):
            getattr(half, name)[k] = stages[stage, columns[first + k]]


@recorded_kernel
def advance_lanes(
    lanes: NDArray[Any],
    drive: NDArray[np.float64],
    drive_of_lane: NDArray[np.int64],
    loads: NDArray[np.float64],
    load_of_lane: NDArray[np.int64],
    shares_drive: int,
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
    shares_drive : int
        1 if all lanes have the same drive, else 0.
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
    first = drive_of_lane[0]
    for i in each(drive.shape[0]):
        stages, now = drive[i], first_step + i
        # A product, not a running sum, whose rounding would grow over the record.
        time = now * step
        if options.closed_loop:
            steer(left, right, stages, drive_of_lane, step, now % steps_per_control == 0, options)
        else:
            with when_else(shares_drive == 1) as (shared, separate):
                with shared:
                    # One load for all lanes, instead of one per lane from its own column.
                    positions = [stages[stage, first] for stage in range(len(SPOOL_STAGES))]
                    for k in each(HALF_WIDTH):
                        for name, position in zip(SPOOL_STAGES, positions, strict=True):
                            getattr(left, name)[k] = getattr(right, name)[k] = position
                with separate:
                    take_spools(left, stages, drive_of_lane, 0)
                    take_spools(right, stages, drive_of_lane, HALF_WIDTH)
        if options.load_force:
            for k in each(HALF_WIDTH):
                left.load[k] = loads[i, load_of_lane[k]]
                right.load[k] = loads[i, load_of_lane[HALF_WIDTH + k]]
        # Before the step, so that the first sample is the initial state.
        with when(i % steps_per_sample == 0):
            sample = samples[i // steps_per_sample]
            take_sample(left, sample, 0, options)
            take_sample(right, sample, HALF_WIDTH, options)
        # Two independent lanes in one loop body hide each other's latencies.
        for k in each(HALF_WIDTH):
            # Drifts and onsets are held over the step; the ripple is that of its middle.
            p = lane_parameters(left, k, time, time + half_step, options)
            q = lane_parameters(right, k, time, time + half_step, options)
            f, g = left.load[k], right.load[k]
            y, z = state_of(left, k), state_of(right, k)
            y1 = hydraulic_rates(y, left.spool_1[k], f, p, options)
            z1 = hydraulic_rates(z, right.spool_1[k], g, q, options)
            y2 = hydraulic_rates(moved(y, half_step, y1, options), left.spool_2[k], f, p, options)
            z2 = hydraulic_rates(moved(z, half_step, z1, options), right.spool_2[k], g, q, options)
            y3 = hydraulic_rates(moved(y, half_step, y2, options), left.spool_3[k], f, p, options)
            z3 = hydraulic_rates(moved(z, half_step, z2, options), right.spool_3[k], g, q, options)
            y4 = hydraulic_rates(moved(y, step, y3, options), left.spool_4[k], f, p, options)
            z4 = hydraulic_rates(moved(z, step, z3, options), right.spool_4[k], g, q, options)
            keep_state(left, k, moved(y, sixth_step, weighted(y1, y2, y3, y4), options), options)
            keep_state(right, k, moved(z, sixth_step, weighted(z1, z2, z3, z4), options), options)
