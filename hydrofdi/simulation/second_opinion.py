"""The same equations through SciPy's solvers: a second opinion on a run.

The six states are integrated together, with an error control of their own, and restarted wherever the input
jumps. Much slower than the kernel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics.valve import spool_acceleration
from hydrofdi.simulation.batch import outcome_of
from hydrofdi.simulation.compilation import compiled
from hydrofdi.simulation.drive import input_voltage
from hydrofdi.simulation.hydraulics import hydraulic_rates, row_parameters
from hydrofdi.simulation.lanes import parameter_matrix
from hydrofdi.simulation.leakage_signal import leakage_signal
from hydrofdi.simulation.options import ModelOptions
from hydrofdi.simulation.trajectory import Trajectory

Solver = Literal["lsoda", "radau"]

RELATIVE_TOLERANCE = 1e-8

_SCALES = np.array([1e-2, 1e-1, 1e6, 1e6, 1e-5, 1e-2])
"""Sizes of x_p [m], v_p [m/s], P_1, P_2 [Pa], x_v [m], v_v [m/s], for the absolute tolerance."""


def simulate_with_solver(
    runs: Sequence[RunParameters],
    leakage_coefficients: Sequence[float],
    solver: Solver,
    tolerance: float = RELATIVE_TOLERANCE,
) -> Trajectory:
    """Simulate runs one after the other with a solver of SciPy.

    Parameters
    ----------
    runs : sequence of RunParameters
        All with the same ``run`` section.
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].
    solver : "lsoda" or "radau"
    tolerance : float
        Relative tolerance of a step.

    Returns
    -------
    Trajectory
        As of ``simulate_batch``; a run that the solver gives up on has NaN from there on, and has diverged.
    """
    run = runs[0].run
    steps = np.arange(run.n_step)
    voltages = np.array([input_voltage(parameters.input, run, steps) for parameters in runs])
    states = np.full((6, len(runs), run.n_sample), np.nan)
    matrix = parameter_matrix(runs, leakage_coefficients)
    for k, parameters in enumerate(runs):
        _solve(parameters, matrix[k], voltages[k], solver, tolerance, states[:, k])
    time = np.arange(run.n_sample) / run.sampling_frequency
    return Trajectory(
        time=time,
        input_voltage=voltages[:, :: run.steps_per_sample],
        spool_position=states[4],
        piston_position=states[0],
        piston_velocity=states[1],
        chamber_1_pressure=states[2],
        chamber_2_pressure=states[3],
        leakage_coefficient=np.array(leakage_coefficients, dtype=float),
        internal_leakage_flow=leakage_signal(runs, leakage_coefficients, time, states[2] - states[3]),
        outcomes=tuple(outcome_of(parameters, states[:4, k]) for k, parameters in enumerate(runs)),
    )


def _solve(
    parameters: RunParameters,
    values: NDArray[np.float64],
    voltage: NDArray[np.float64],
    solver: Solver,
    tolerance: float,
    states: NDArray[np.float64],
) -> None:
    """Integrate one run from jump to jump of its input, and fill its samples (6, n_time)."""
    from scipy import integrate

    solve_ivp: Any = integrate.solve_ivp
    run, valve, supply = parameters.run, parameters.valve, parameters.supply
    spool = np.array([2.0 * math.pi * valve.natural_frequency, valve.damping_ratio, valve.spool_gain])
    options = ModelOptions.of(parameters)
    rest = 0.5 * (supply.pressure + supply.return_pressure)
    state = np.array([0.0, 0.0, rest, rest, 0.0, 0.0])
    smooth = parameters.input.is_smooth
    edges = [] if smooth else (np.flatnonzero(np.diff(voltage)) + 1).tolist()
    jumps = [0, *edges, run.n_step]
    for first, last in pairwise(jumps):
        samples = np.arange(-(-first // run.steps_per_sample), -(-last // run.steps_per_sample))
        instants = np.append(samples * run.steps_per_sample, last) * run.step
        held = voltage if smooth else voltage[first : first + 1]
        with np.errstate(all="ignore"):
            result = solve_ivp(
                all_rates, (first * run.step, last * run.step), state,
                method=solver.upper() if solver == "lsoda" else "Radau",
                t_eval=instants, args=(held, run.step, spool, values, options),
                rtol=tolerance, atol=tolerance * _SCALES,
            )  # fmt: skip
        if not result.success or result.y.shape[1] < instants.size:
            return
        states[:, samples] = result.y[:, :-1]
        state = result.y[:, -1]


@compiled
def all_rates(
    time: float,
    state: NDArray[np.float64],
    voltage: NDArray[np.float64],
    step: float,
    spool: NDArray[np.float64],
    values: NDArray[np.float64],
    options: ModelOptions,
) -> NDArray[np.float64]:
    """Time derivatives of x_p, v_p, P_1, P_2, x_v, v_v.

    Parameters
    ----------
    time : float
        t [s].
    state : ndarray, shape (6,)
    voltage : ndarray, shape (1,) or (n_step,)
        u [V]: constant, or smooth and held over each step; then it is interpolated between their middles.
    step : float
        Length of a step [s].
    spool : ndarray, shape (3,)
        ω_v [rad/s], ξ [-], k_v [m/V].
    values : ndarray, shape (n_parameter,)
        In the order of ``lanes.PARAMETERS``.
    options : ModelOptions
    """
    place = min(max(time / step - 0.5, 0.0), voltage.size - 1.0)
    k = min(int(place), max(voltage.size - 2, 0))
    u = voltage[k] + (place - k) * (voltage[min(k + 1, voltage.size - 1)] - voltage[k])
    rates = np.empty(6)
    p = row_parameters(values, time, options)
    hydraulic = hydraulic_rates((state[0], state[1], state[2], state[3]), state[4], p, options)
    rates[0], rates[1], rates[2], rates[3] = hydraulic
    rates[4] = state[5]
    rates[5] = spool_acceleration(state[4], state[5], u, spool[0], spool[1], spool[2])
    return rates
