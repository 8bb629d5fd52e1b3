"""Motion of spools over a Runge-Kutta step: of several drives in open loop, of every lane in closed loop.

A spool does not depend on the hydraulics, so within a step it is advanced before them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.physics.equation import equation, limited, settled
from hydrofdi.physics.valve import acting_voltage, spool_acceleration
from hydrofdi.simulation.kernels.lanes import WIDTH, Chosen


@equation
def spool_rates(
    position: float,
    velocity: float,
    voltage: float,
    frequency: float,
    damping_ratio: float,
    gain: float,
    position_limit: float,
    speed_limit: float,
    is_limited: Chosen,
) -> tuple[float, float]:
    """x_v' [m/s] and v_v' [m/s²]; with limits, command and speed saturate."""
    if is_limited is not None:
        command = limited(voltage, position_limit / gain)
        return (
            limited(velocity, speed_limit),
            spool_acceleration(position, velocity, command, frequency, damping_ratio, gain),
        )
    return velocity, spool_acceleration(position, velocity, voltage, frequency, damping_ratio, gain)


@equation
def valve_opening(position: float, position_limit: float, is_limited: Chosen) -> float:
    """Spool position that acts on the ports, after saturation [m]."""
    if is_limited is not None:
        opening: float = limited(position, position_limit)
        return opening
    return position


@equation
def move_spool(spools: Any, k: int, step: float, is_limited: Chosen, has_hysteresis: Chosen) -> None:
    """Advance spool `k` of a record by one step, and store its openings at the four stages."""
    u = spools.voltage[k]
    if has_hysteresis is not None:
        u = spools.acting_voltage[k] = acting_voltage(u, spools.acting_voltage[k], spools.hysteresis[k])
    w, xi, k_v = (
        spools.spool_frequency[k],
        spools.spool_damping_ratio[k],
        spools.spool_gain[k],
    )
    most, fastest = spools.spool_limit[k], spools.spool_speed_limit[k]
    x, v = spools.spool_position[k], spools.spool_velocity[k]
    half_step, sixth_step = 0.5 * step, step / 6.0
    r1, a1 = spool_rates(x, v, u, w, xi, k_v, most, fastest, is_limited)
    x2, v2 = x + half_step * r1, v + half_step * a1
    r2, a2 = spool_rates(x2, v2, u, w, xi, k_v, most, fastest, is_limited)
    x3, v3 = x + half_step * r2, v + half_step * a2
    r3, a3 = spool_rates(x3, v3, u, w, xi, k_v, most, fastest, is_limited)
    x4, v4 = x + step * r3, v + step * a3
    r4, a4 = spool_rates(x4, v4, u, w, xi, k_v, most, fastest, is_limited)
    spools.spool_1[k] = valve_opening(x, most, is_limited)
    spools.spool_2[k] = valve_opening(x2, most, is_limited)
    spools.spool_3[k] = valve_opening(x3, most, is_limited)
    spools.spool_4[k] = valve_opening(x4, most, is_limited)
    spools.spool_position[k] = settled(x + sixth_step * (r1 + 2.0 * (r2 + r3) + r4))
    spools.spool_velocity[k] = settled(v + sixth_step * (a1 + 2.0 * (a2 + a3) + a4))


@kernel
def advance_spools(
    spools: NDArray[Any],
    voltage: NDArray[np.float64],
    step: float,
    first_drive: int,
    n_drive: int,
    stages: NDArray[np.float64],
    is_limited: Chosen,
    has_hysteresis: Chosen,
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
    is_limited : True or None
        Whether position or speed of any spool saturates.
    has_hysteresis : True or None
        Whether any spool has hysteresis.
    """
    spool = spools[0]
    for i in range(voltage.shape[0]):
        for k in range(n_drive):
            spool.voltage[k] = voltage[i, first_drive + k]
        for k in range(WIDTH):
            move_spool(spool, k, step, is_limited, has_hysteresis)
        for k in range(n_drive):
            stages[i, 0, first_drive + k] = spool.spool_1[k]
            stages[i, 1, first_drive + k] = spool.spool_2[k]
            stages[i, 2, first_drive + k] = spool.spool_3[k]
            stages[i, 3, first_drive + k] = spool.spool_4[k]
