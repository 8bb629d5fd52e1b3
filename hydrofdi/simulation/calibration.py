"""Calibration of the leakage coefficient K_i to a given mean leakage flow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.drive import largest_leakage_flows, no_load_flow
from hydrofdi.simulation.kernels.lanes import positions_by

RELATIVE_TOLERANCE = 1e-10
"""Relative tolerance of K_i."""

_LARGEST_SURPLUS = 1e-6
"""Largest relative deviation of the leakage from the request; a root with more is rejected."""

_MOST_TRIALS = 12
"""Number of times the upper end of the bracket is tripled before a flow counts as unreachable."""


@dataclass(frozen=True)
class Calibration:
    """Solution of one calibration.

    Attributes
    ----------
    coefficient : float
        K_i [m^3.5/kg^0.5]; NaN if no K_i gives the flow.
    reachable_flow : float
        Largest mean flow found during the search [m³/s].
    """

    coefficient: float
    reachable_flow: float


def solve_leakage_coefficients(conditions: Sequence[RunParameters]) -> list[Calibration]:
    """Solve for K_i such that the mean of abs(q_il) over the record equals ``leakage.internal_flow``.

    The conditions are solved in parallel lanes; no solution depends on the others.

    Parameters
    ----------
    conditions : sequence of RunParameters
        Runs with a positive internal flow.
    """
    solutions: dict[int, Calibration] = {}
    for members in positions_by(parameters.record for parameters in conditions).values():
        solved = _solve_group([conditions[k] for k in members])
        solutions |= dict(zip(members, solved, strict=True))
    return [solutions[k] for k in range(len(conditions))]


def _solve_group(conditions: Sequence[RunParameters]) -> list[Calibration]:
    from scipy.optimize.elementwise import find_root

    target = np.array([parameters.leakage.internal_flow for parameters in conditions], dtype=float)
    upper, reachable = _upper_bracket(conditions, target)
    solvable = np.flatnonzero(np.isfinite(upper))
    coefficients = np.full(len(conditions), np.nan)
    if solvable.size:

        def surplus(coefficient: NDArray[np.float64], index: NDArray[np.int64]) -> NDArray[np.float64]:
            flow = _mean_flow([conditions[int(k)] for k in index], coefficient)
            relative: NDArray[np.float64] = np.nan_to_num(flow) / target[index] - 1.0
            return relative

        result = find_root(
            surplus,
            (np.zeros(solvable.size), upper[solvable]),
            args=(solvable,),
            tolerances={"xrtol": RELATIVE_TOLERANCE, "xatol": 0.0, "frtol": 0.0, "fatol": 0.0},
        )
        leaks_enough = np.abs(surplus(result.x, solvable)) < _LARGEST_SURPLUS
        coefficients[solvable] = np.where(leaks_enough, result.x, np.nan)
    return [Calibration(float(k), float(q)) for k, q in zip(coefficients, reachable, strict=True)]


def _upper_bracket(
    conditions: Sequence[RunParameters], target: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients whose leakage is at least the target (NaN if none), and the largest flows found."""
    supply = np.array([parameters.supply.pressure for parameters in conditions])
    from_valve = np.array([no_load_flow(parameters) for parameters in conditions])
    start = np.where(from_valve > 0.0, np.minimum(target, from_valve), target)
    trial = start / np.sqrt(0.25 * supply)
    upper = np.full(len(conditions), np.nan)
    reachable = np.zeros(len(conditions))
    for _ in range(_MOST_TRIALS):
        open_ = np.flatnonzero(np.isnan(upper))
        if not open_.size:
            break
        flow = _mean_flow([conditions[int(k)] for k in open_], trial[open_])
        reachable[open_] = np.fmax(reachable[open_], flow)
        reached = flow >= target[open_]
        upper[open_[reached]] = trial[open_[reached]]
        trial[open_[~reached]] *= 3.0
    return upper, reachable


def _mean_flow(runs: Sequence[RunParameters], coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean leakage flows [m³/s]; NaN for runs that failed or chatter, as happens if K_i is very large."""
    trajectory = simulate_batch(runs, list(coefficients))
    flow = trajectory.mean_internal_leakage_flow
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    chatters = flow > largest_leakage_flows(runs, trajectory)
    return np.where(failed | chatters, np.nan, flow)
