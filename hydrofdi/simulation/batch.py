"""Simulation of a batch of runs in lanes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.run import RunConfig
from hydrofdi.simulation.drive import Drive, Spools
from hydrofdi.simulation.kernel import advance_lanes
from hydrofdi.simulation.lanes import STATES, WIDTH, pack_lanes
from hydrofdi.simulation.leakage_signal import leakage_signal
from hydrofdi.simulation.options import ModelOptions, group_by_options
from hydrofdi.simulation.trajectory import Outcome, Trajectory

_CHUNK_STEPS, _CHUNK_SPOOL_STEPS = 2000, 64_000
"""About so many steps are taken at a time, for all spools together, so that a chunk stays in the cache."""

ABSURD_PRESSURE_RATIO = 100.0
"""A run whose pressure exceeds the supply so many times has diverged, even while it is finite."""


_CLOSE_TO_STOP = 0.98
"""A run that diverges from a sample this far along the stroke has met the end of the cylinder."""


def simulate_batch(runs: Sequence[RunParameters], leakage_coefficients: Sequence[float]) -> Trajectory:
    """Simulate runs side by side. A run's signals do not depend on the others.

    Parameters
    ----------
    runs : sequence of RunParameters
        At least one; all with the same ``run`` section. Their own internal leakage is not looked at.
    leakage_coefficients : sequence of float
        K_i of each run [m^3.5/kg^0.5].

    Returns
    -------
    Trajectory
        Runs that went wrong are in it, with an outcome that says so.

    Raises
    ------
    ValueError
        No runs, or runs of different duration, step or sampling.
    """
    if len({parameters.run for parameters in runs}) != 1:
        raise ValueError("the runs of a batch must share duration, step and sampling frequency")
    run = runs[0].run
    drives = list(dict.fromkeys(Drive.of(parameters) for parameters in runs))
    drive_of_run = np.array([drives.index(Drive.of(parameters)) for parameters in runs])
    states, voltage, spool = _integrate(runs, leakage_coefficients, drives, drive_of_run, run)
    position, velocity, pressure_1, pressure_2 = states
    time = np.arange(run.n_sample) / run.sampling_frequency
    return Trajectory(
        time=time,
        input_voltage=voltage[drive_of_run],
        spool_position=spool[drive_of_run],
        piston_position=position,
        piston_velocity=velocity,
        chamber_1_pressure=pressure_1,
        chamber_2_pressure=pressure_2,
        leakage_coefficient=np.array(leakage_coefficients, dtype=float),
        internal_leakage_flow=leakage_signal(runs, leakage_coefficients, time, pressure_1 - pressure_2),
        outcomes=tuple(outcome_of(parameters, states[:, k]) for k, parameters in enumerate(runs)),
    )


def _integrate(
    runs: Sequence[RunParameters],
    leakage_coefficients: Sequence[float],
    drives: Sequence[Drive],
    drive_of_run: NDArray[np.int64],
    run: RunConfig,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """States (4, n_run, n_time); voltage and spool position (n_drive, n_time)."""
    blocks = [
        _Block(options, group[first : first + WIDTH], runs, leakage_coefficients, drive_of_run)
        for options, group in group_by_options(runs)
        for first in range(0, len(group), WIDTH)
    ]
    states = np.empty((len(STATES), len(runs), run.n_sample))
    voltage, spool = np.empty((2, len(drives), run.n_sample))
    spools = Spools(drives, run)
    chunk = max(1, min(_CHUNK_STEPS, _CHUNK_SPOOL_STEPS // len(drives)) // run.steps_per_sample)
    for first in range(0, run.n_sample, chunk):
        window = slice(first, min(first + chunk, run.n_sample))
        n_sample = window.stop - window.start
        steps = n_sample * run.steps_per_sample
        chunk_voltage, stages = spools.advance(first * run.steps_per_sample, steps)
        voltage[:, window] = chunk_voltage[:: run.steps_per_sample, : len(drives)].T
        spool[:, window] = stages[:: run.steps_per_sample, 0, : len(drives)].T
        samples = np.empty((n_sample, len(STATES), WIDTH))
        for block in blocks:
            advance_lanes(
                block.lanes, stages, block.drive_of_lane, run.step, run.steps_per_sample, samples,
                first * run.steps_per_sample, block.options,
            )  # fmt: skip
            states[:, block.members, window] = samples[:, :, : len(block.members)].transpose(1, 2, 0)
    return states, voltage, spool


class _Block:
    """Up to WIDTH runs of a batch that share their options, in lanes."""

    def __init__(
        self,
        options: ModelOptions,
        members: list[int],
        runs: Sequence[RunParameters],
        leakage_coefficients: Sequence[float],
        drive_of_run: NDArray[np.int64],
    ) -> None:
        self.options, self.members = options, members
        self.lanes = pack_lanes([runs[k] for k in members], [leakage_coefficients[k] for k in members])
        self.drive_of_lane = np.resize(drive_of_run[members], WIDTH)


def outcome_of(parameters: RunParameters, states: NDArray[np.float64]) -> Outcome:
    """How a run ended, from its states (4, n_time)."""
    run, actuator = parameters.run, parameters.actuator
    pressure_limit = ABSURD_PRESSURE_RATIO * parameters.supply.pressure
    stroke = actuator.chamber_volume / actuator.piston_area
    with np.errstate(invalid="ignore"):
        diverged = ~np.all(np.isfinite(states), axis=0) | np.any(np.abs(states[2:]) > pressure_limit, axis=0)
        beyond = np.abs(states[0]) >= stroke
    at_the_stop = diverged.any() and abs(states[0, np.argmax(diverged) - 1]) > _CLOSE_TO_STOP * stroke
    if diverged.any() and not at_the_stop:
        time = np.argmax(diverged) / run.sampling_frequency
        return Outcome(
            "diverged",
            f"the state grew without bound by t = {time:g} s; the step of {run.step:g} s is too long",
        )
    if beyond.any() or at_the_stop:
        time = np.argmax(beyond | diverged) / run.sampling_frequency
        return Outcome(
            "stroke_exceeded",
            f"the piston left the cylinder (stroke ±{stroke:.4g} m) at t = {time:g} s",
        )
    return Outcome()
