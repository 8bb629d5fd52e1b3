"""Motion of spools over a Runge-Kutta step: of several drives in open loop, of every lane in closed loop.

A spool does not depend on the hydraulics, so within a step it is advanced before them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import recorded_kernel
from hydrofdi.compilation.symbols import each
from hydrofdi.physics.equation import NEGLIGIBLE, Quantity, limited
from hydrofdi.physics.valve import acting_voltage, spool_acceleration
from hydrofdi.simulation.kernels.lanes import WIDTH

SPOOL_STAGES = ("spool_1", "spool_2", "spool_3", "spool_4")
"""Lane fields of the spool position at the four stages of a step."""


# `physics.equation.settled` for symbols, which have no branches; numba would make an array of this one.
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
    w, xi, k_v = (
        spools.spool_frequency[k],
        spools.spool_damping_ratio[k],
        spools.spool_gain[k],
    )
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
