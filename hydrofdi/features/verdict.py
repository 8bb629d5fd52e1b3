"""How far a run can be believed: a verdict from its record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.simulation import Trajectory
from hydrofdi.simulation.balances import balance_residuals

UNSETTLED_CHANGE = 0.01
"""A record whose last two periods differ by more than this share of the pressure's RMS is unsettled."""

LEAST_VARIATION = 1e-6
"""The RMS that a change is put over is at least this share of the supply, so that rest counts as settled."""

STILL = 1e-9
"""A record whose P_1 varies by less than this share of the supply stands still: what varies is rounding."""


@dataclass(frozen=True)
class Verdicts:
    """Verdicts of a batch of runs and the numbers behind them, each of shape (n_run,).

    Attributes
    ----------
    verdict : ndarray of str
        The status of a run that failed; else ``ok``, or what its numbers have to be read with:
        ``cavitating``, ``above_supply``, ``unsettled``, ``clipped``, ``still``, joined by commas.
    cavitating_share, above_supply_share : ndarray
        Share of the samples with a chamber pressure at or below the vapour limit, or above the supply [-].
    settling_change : ndarray
        RMS of the change of P_1 from the last but one period to the last, over the RMS of its variation in
        the last, or over `LEAST_VARIATION` of the supply where that is more [-]; NaN where the record does
        not hold two whole periods.
    clipped_share : ndarray
        Share of the samples of P_1 at an end of its sensor's range [-].
    pressure_variation : ndarray
        Largest less least P_1, over the supply pressure [-].
    volume_residual, energy_residual : ndarray
        What the balances lack [-].
    """

    verdict: NDArray[np.object_]
    cavitating_share: NDArray[np.float64]
    above_supply_share: NDArray[np.float64]
    settling_change: NDArray[np.float64]
    clipped_share: NDArray[np.float64]
    pressure_variation: NDArray[np.float64]
    volume_residual: NDArray[np.float64]
    energy_residual: NDArray[np.float64]


def judge(runs: Sequence[RunParameters], trajectory: Trajectory, measured: Trajectory) -> Verdicts:
    """Verdicts on runs; those that failed have NaN for numbers.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
    trajectory : Trajectory
        What really happened.
    measured : Trajectory
        The same as the sensors show it.
    """
    pressure_1, pressure_2 = trajectory.chamber_1_pressure, trajectory.chamber_2_pressure
    vapour = np.array([run.fluid.vapour_pressure for run in runs])[:, None]
    supply = trajectory.valve_supply_pressure
    residuals = balance_residuals(runs, trajectory)
    numbers = [
        np.mean((pressure_1 <= vapour) | (pressure_2 <= vapour), axis=1),
        np.mean((pressure_1 > supply) | (pressure_2 > supply), axis=1),
        np.array([_settling_change(run, pressure_1[k]) for k, run in enumerate(runs)]),
        np.array([_clipped_share(run, measured.chamber_1_pressure[k]) for k, run in enumerate(runs)]),
        np.ptp(pressure_1, axis=1) / np.array([run.supply.pressure for run in runs]),
        residuals.volume,
        residuals.energy,
    ]
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    for values in numbers:
        values[failed] = np.nan
    words = [
        _words(*shares) if outcome.is_ok else outcome.status
        for outcome, *shares in zip(trajectory.outcomes, *numbers[:5], strict=True)
    ]
    return Verdicts(np.array(words, dtype=object), *numbers)


def _words(
    cavitating_share: float,
    above_supply_share: float,
    settling_change: float,
    clipped_share: float,
    pressure_variation: float,
) -> str:
    findings = {
        "cavitating": cavitating_share > 0.0,
        "above_supply": above_supply_share > 0.0,
        "unsettled": settling_change > UNSETTLED_CHANGE,
        "clipped": clipped_share > 0.0,
        "still": pressure_variation < STILL,
    }
    return ", ".join(word for word, found in findings.items() if found) or "ok"


def _settling_change(run: RunParameters, pressure: NDArray[np.float64]) -> float:
    n_period = run.input.period * run.run.sampling_frequency
    n_sample = round(n_period)
    if not run.is_periodic or abs(n_period - n_sample) > 1e-6 or pressure.size < 2 * n_sample:
        return float("nan")
    last, before = pressure[-n_sample:], pressure[-2 * n_sample : -n_sample]
    variation = max(float(np.std(last)), LEAST_VARIATION * run.supply.pressure)
    return float(np.sqrt(np.mean((last - before) ** 2))) / variation


def _clipped_share(run: RunParameters, shown: NDArray[np.float64]) -> float:
    """Share of samples at an end of the range, or on the level of the converter that lies there."""
    sensor = run.pressure_1_sensor
    lowest = -math.inf if sensor.lowest is None else sensor.lowest
    highest = math.inf if sensor.highest is None else sensor.highest
    slack = 0.5 * sensor.resolution
    return float(np.mean((shown <= lowest + slack) | (shown >= highest - slack)))
