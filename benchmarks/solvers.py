"""General solvers with error control, restarted at every edge of the input.

States are scaled to about one, because numbalsoda has a single absolute tolerance: rtol 1e-6, and atol
1e-6 of the scale (1 Pa for the pressures). SciPy calls the same compiled rates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numba
import numpy as np
from jobs import Job, parameter_vector
from plain_loop import rates

from hydrofdi.simulation.inputs import input_voltage

RELATIVE_TOLERANCE = ABSOLUTE_TOLERANCE = 1e-6
SCALE = np.array([1e-2, 1e-1, 1e-5, 1e-2, 1e6, 1e6])
"""Scale of (x_p, v_p, x_v, v_v, P_1, P_2) in SI."""


@numba.njit(cache=True)
def scaled_rates(t, y, u, p):
    dy = np.empty(6)
    rates(y * SCALE, u, p, dy)
    return dy / SCALE


def segments(job: Job) -> Iterator[tuple[np.ndarray, float]]:
    """Segments between edges of the input: sampling instants including both ends [s], and u [V]."""
    record, drive = job[0].record, job[0].input
    per_half = round(drive.period / 2 * record.sampling_frequency)
    for first in range(0, record.n_sample, per_half):
        instants = np.arange(first, min(first + per_half, record.n_sample) + 1) / record.sampling_frequency
        step = np.array([first * record.steps_per_sample])
        yield instants, float(input_voltage(drive, record, step)[0])


def scipy_lsoda(job: Job) -> np.ndarray:
    """Samples of P_1 [Pa] by ``scipy.integrate.solve_ivp``, method LSODA."""
    from scipy.integrate import solve_ivp

    def solve(y, instants, u, p):
        solution = solve_ivp(
            scaled_rates, (instants[0], instants[-1]), y, "LSODA", instants, args=(u, p),
            rtol=RELATIVE_TOLERANCE, atol=ABSOLUTE_TOLERANCE,
        )  # fmt: skip
        return solution.y.T

    return _solve_segments(job, solve)


def numbalsoda_solver() -> Callable[[Job], np.ndarray] | None:
    """The same with numbalsoda; None if it is not installed."""
    try:
        from numbalsoda import lsoda, lsoda_sig
    except (ImportError, OSError):
        return None

    @numba.cfunc(lsoda_sig)
    def scaled_rates_of_pointers(t, y, dy, data):
        values = numba.carray(data, (20,))
        state = numba.carray(y, (6,))
        rate = numba.carray(dy, (6,))
        result = scaled_rates(t, state, values[19], values[:19])
        for j in range(6):
            rate[j] = result[j]

    address = scaled_rates_of_pointers.address

    def solve(y, instants, u, p):
        data = np.append(p, u)
        states, success = lsoda(address, y, instants, data, RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE)
        if not success:
            raise RuntimeError("numbalsoda failed")
        return states

    return lambda job: _solve_segments(job, solve)


def _solve_segments(job: Job, solve: Callable[..., np.ndarray]) -> np.ndarray:
    p = parameter_vector(job)
    y = np.array([0.0, 0.0, 0.0, 0.0, (p[4] + p[5]) / 2, (p[4] + p[5]) / 2]) / SCALE
    pressures = []
    for instants, u in segments(job):
        states = solve(y, instants, u, p)
        pressures.append(states[:-1, 4] * SCALE[4])
        y = np.ascontiguousarray(states[-1])
    return np.concatenate(pressures)
