"""The compiled kernels: classic Runge-Kutta of the six states, many runs side by side.

The spool does not depend on the hydraulics. It is integrated once for all runs that share its drive, and
its positions at the four stages of every step are handed to the lanes: the same numbers as in a joint
integration.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.physics.equation import equation
from hydrofdi.physics.valve import spool_acceleration
from hydrofdi.simulation.compilation import compiled
from hydrofdi.simulation.hydraulics import LaneParameters, State, hydraulic_rates, open_leakage
from hydrofdi.simulation.lanes import HALF_WIDTH, SPOOL_WIDTH
from hydrofdi.simulation.options import ModelOptions


@equation
def moved(state: State, time: float, rates: State) -> State:
    """The state after going along `rates` for a time."""
    return (
        state[0] + time * rates[0],
        state[1] + time * rates[1],
        state[2] + time * rates[2],
        state[3] + time * rates[3],
    )


@equation
def weighted(first: State, second: State, third: State, fourth: State) -> State:
    """Six times the mean rates of classic Runge-Kutta: k1 + 2 k2 + 2 k3 + k4."""
    return (
        first[0] + 2.0 * (second[0] + third[0]) + fourth[0],
        first[1] + 2.0 * (second[1] + third[1]) + fourth[1],
        first[2] + 2.0 * (second[2] + third[2]) + fourth[2],
        first[3] + 2.0 * (second[3] + third[3]) + fourth[3],
    )


@equation
def lane_parameters(half: Any, lane: int, time: float, options: ModelOptions) -> LaneParameters:
    """The parameters of one lane at an instant."""
    return LaneParameters(
        half.mass[lane], half.area[lane], half.volume[lane], half.stiffness[lane],
        half.supply[lane], half.ret[lane], half.bulk_modulus[lane],
        half.flow_gain[lane], half.area_gradient[lane],
        half.coulomb[lane], half.breakaway[lane], half.viscous[lane],
        half.transition[lane], half.velocity_threshold[lane],
        open_leakage(
            time, half.internal_leakage[lane], half.onset_time[lane], half.onset_duration[lane],
            half.onset_duty[lane], options,
        ),
        half.external_leakage_1[lane], half.external_leakage_2[lane],
        half.laminar_reference[lane], half.blending_pressure[lane],
        half.onset_time[lane], half.onset_duration[lane], half.onset_duty[lane],
    )  # fmt: skip


@compiled
def advance_lanes(
    lanes: NDArray[Any],
    spool: NDArray[np.float64],
    drive_of_lane: NDArray[np.int64],
    step: float,
    steps_per_sample: int,
    samples: NDArray[np.float64],
    first_step: int,
    options: ModelOptions,
) -> None:
    """Advance all lanes by the steps of `spool`, and sample them on the way.

    Parameters
    ----------
    lanes : ndarray of LANES, shape (1,)
        Parameters and state; the state is updated in place.
    spool : ndarray, shape (n_step, 4, n_drive)
        Spool position at the stages of each step, one column per drive [m].
    drive_of_lane : ndarray, shape (WIDTH,)
        Column of each lane.
    step : float
        Runge-Kutta step h [s].
    steps_per_sample : int
        A sample is taken before every so many steps, the first step included.
    samples : ndarray, shape (n_step / steps_per_sample, 4, WIDTH)
        Filled with x_p [m], v_p [m/s], P_1 and P_2 [Pa].
    first_step : int
        Number of the first step, counted from the start of the record.
    options : ModelOptions
        Choices that all lanes share.
    """
    left, right = lanes[0].left, lanes[0].right
    half_step, sixth_step = 0.5 * step, step / 6.0
    first, share_drive = drive_of_lane[0], drive_of_lane.min() == drive_of_lane.max()
    for i in range(spool.shape[0]):
        if i % steps_per_sample == 0:
            sample = samples[i // steps_per_sample]
            for k in range(HALF_WIDTH):
                sample[0, k] = left.position[k]
                sample[1, k] = left.velocity[k]
                sample[2, k] = left.pressure_1[k]
                sample[3, k] = left.pressure_2[k]
            for k in range(HALF_WIDTH):
                sample[0, HALF_WIDTH + k] = right.position[k]
                sample[1, HALF_WIDTH + k] = right.velocity[k]
                sample[2, HALF_WIDTH + k] = right.pressure_1[k]
                sample[3, HALF_WIDTH + k] = right.pressure_2[k]
        stages = spool[i]
        time = (first_step + i) * step
        if share_drive:
            stage_1, stage_2 = stages[0, first], stages[1, first]
            stage_3, stage_4 = stages[2, first], stages[3, first]
            for k in range(HALF_WIDTH):
                left.spool_1[k] = right.spool_1[k] = stage_1
                left.spool_2[k] = right.spool_2[k] = stage_2
                left.spool_3[k] = right.spool_3[k] = stage_3
                left.spool_4[k] = right.spool_4[k] = stage_4
        else:
            for k in range(HALF_WIDTH):
                drive = drive_of_lane[k]
                left.spool_1[k] = stages[0, drive]
                left.spool_2[k] = stages[1, drive]
                left.spool_3[k] = stages[2, drive]
                left.spool_4[k] = stages[3, drive]
                drive = drive_of_lane[HALF_WIDTH + k]
                right.spool_1[k] = stages[0, drive]
                right.spool_2[k] = stages[1, drive]
                right.spool_3[k] = stages[2, drive]
                right.spool_4[k] = stages[3, drive]
        # Two independent lanes in one body hide each other's latencies.
        for k in range(HALF_WIDTH):
            p = lane_parameters(left, k, time, options)
            q = lane_parameters(right, k, time, options)
            y = (left.position[k], left.velocity[k], left.pressure_1[k], left.pressure_2[k])
            z = (right.position[k], right.velocity[k], right.pressure_1[k], right.pressure_2[k])
            y1 = hydraulic_rates(y, left.spool_1[k], p, options)
            z1 = hydraulic_rates(z, right.spool_1[k], q, options)
            y2 = hydraulic_rates(moved(y, half_step, y1), left.spool_2[k], p, options)
            z2 = hydraulic_rates(moved(z, half_step, z1), right.spool_2[k], q, options)
            y3 = hydraulic_rates(moved(y, half_step, y2), left.spool_3[k], p, options)
            z3 = hydraulic_rates(moved(z, half_step, z2), right.spool_3[k], q, options)
            y4 = hydraulic_rates(moved(y, step, y3), left.spool_4[k], p, options)
            z4 = hydraulic_rates(moved(z, step, z3), right.spool_4[k], q, options)
            y = moved(y, sixth_step, weighted(y1, y2, y3, y4))
            z = moved(z, sixth_step, weighted(z1, z2, z3, z4))
            left.position[k], left.velocity[k], left.pressure_1[k], left.pressure_2[k] = y
            right.position[k], right.velocity[k], right.pressure_1[k], right.pressure_2[k] = z


@compiled
def advance_spools(
    spools: NDArray[Any],
    voltage: NDArray[np.float64],
    step: float,
    first_drive: int,
    stages: NDArray[np.float64],
) -> None:
    """Integrate a record of spools and keep their positions at the stages of each step.

    Parameters
    ----------
    spools : ndarray of SPOOLS, shape (1,)
        ω_v [rad/s], ξ [-], k_v [m/V] and state [m], [m/s]; the state is updated in place.
    voltage : ndarray, shape (n_step, n_drive)
        Input, held over each step [V].
    step : float
        Runge-Kutta step h [s].
    first_drive : int
        Column of the first of these spools.
    stages : ndarray, shape (n_step, 4, n_drive)
        Filled with spool positions [m], in SPOOL_WIDTH columns.
    """
    spool = spools[0]
    for i in range(voltage.shape[0]):
        for k in range(SPOOL_WIDTH):
            spool.voltage[k] = voltage[i, first_drive + k]
        for k in range(SPOOL_WIDTH):
            x, v, u = spool.position[k], spool.velocity[k], spool.voltage[k]
            w, xi, k_v = spool.frequency[k], spool.damping_ratio[k], spool.gain[k]
            a1 = spool_acceleration(x, v, u, w, xi, k_v)
            x2, v2 = x + 0.5 * step * v, v + 0.5 * step * a1
            a2 = spool_acceleration(x2, v2, u, w, xi, k_v)
            x3, v3 = x + 0.5 * step * v2, v + 0.5 * step * a2
            a3 = spool_acceleration(x3, v3, u, w, xi, k_v)
            x4, v4 = x + step * v3, v + step * a3
            a4 = spool_acceleration(x4, v4, u, w, xi, k_v)
            spool.stage_1[k], spool.stage_2[k], spool.stage_3[k], spool.stage_4[k] = x, x2, x3, x4
            spool.position[k] = x + step / 6.0 * (v + 2.0 * (v2 + v3) + v4)
            spool.velocity[k] = v + step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        for k in range(SPOOL_WIDTH):
            stages[i, 0, first_drive + k] = spool.stage_1[k]
            stages[i, 1, first_drive + k] = spool.stage_2[k]
            stages[i, 2, first_drive + k] = spool.stage_3[k]
            stages[i, 3, first_drive + k] = spool.stage_4[k]
