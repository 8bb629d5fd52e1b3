"""How far runs can be believed: a verdict on each from its record, and the numbers behind it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.request import parameter_names, parameter_quantity
from hydrofdi.quality.doubts import DOUBTS, SOUND, Settling
from hydrofdi.simulation.balances import balance_residuals
from hydrofdi.simulation.trajectory import Trajectory
from hydrofdi.units import parse_quantity

_MACHINE = ("actuator", "fluid", "supply", "valve", "friction")
"""Sections that describe a machine."""

_USUAL_DAMPING_RATIO = 0.02
"""That of the nominal actuator of the paper; real ones have 0.05 to 0.4."""


def assess_runs(
    runs: Sequence[RunParameters],
    trajectory: Trajectory,
    measured: Trajectory,
    settlings: Sequence[Settling],
    damping_ratios: NDArray[np.float64],
) -> dict[str, NDArray[Any]]:
    """Verdicts on runs and the numbers behind them; those that failed have NaN for numbers.

    Parameters
    ----------
    runs : sequence of RunParameters, length n_run
    trajectory : Trajectory
        What really happened.
    measured : Trajectory
        The same as the sensors show it.
    settlings : sequence of Settling, length n_run
        How its details settle.
    damping_ratios : ndarray, shape (n_run,)
        Of the hydraulic mode [-].

    Returns
    -------
    dict of str to ndarray, shape (n_run,)
        ``verdict``: the status of a run that failed; else ``ok``, or the words of its `DOUBTS`, joined by
        commas. ``cavitating_share``, ``above_supply_share``: of the samples with a chamber pressure at or
        below the vapour limit, or above the supply [-]. ``settling_change``: largest relative change of the
        RMS of a detail from the last but one period to the last [-]; NaN where the record does not contain
        two whole periods. ``settled_from``: start of the whole periods that agree with the last one [s]; NaN
        if there are none. ``clipped_share``: of the samples of P_1 at an end of its sensor's range [-].
        ``pressure_variation``: largest less least P_1, over the supply [-]. ``unusual_share``: by how much a
        parameter or the damping ratio of the mode misses its usual range: 1 less its ratio to the
        nearest end, or the inverse [-]. ``volume_residual``, ``energy_residual``: of the balances, relative.
    """
    pressure_1, pressure_2 = trajectory.chamber_1_pressure, trajectory.chamber_2_pressure
    vapour = np.array([run.fluid.vapour_pressure for run in runs])[:, None]
    supply = trajectory.valve_supply_pressure
    residuals = balance_residuals(runs, trajectory)
    quality: dict[str, NDArray[Any]] = {
        "cavitating_share": np.mean((pressure_1 <= vapour) | (pressure_2 <= vapour), axis=1),
        "above_supply_share": np.mean((pressure_1 > supply) | (pressure_2 > supply), axis=1),
        "settling_change": np.array([settling.change for settling in settlings]),
        "settled_from": np.array([*map(_settled_from, runs, settlings)]),
        "clipped_share": np.array([*map(_clipped_share, runs, measured.chamber_1_pressure)]),
        "pressure_variation": np.ptp(pressure_1, axis=1) / np.array([run.supply.pressure for run in runs]),
        "unusual_share": np.array([*map(_unusual_share, runs, damping_ratios)]),
        "volume_residual": residuals.volume,
        "energy_residual": residuals.energy,
    }
    failed = np.array([not outcome.is_ok for outcome in trajectory.outcomes])
    for values in quality.values():
        values[failed] = np.nan
    verdict = np.array([outcome.status for outcome in trajectory.outcomes], dtype=object)
    for row in np.flatnonzero(~failed).tolist():
        words = [word for word, doubt in DOUBTS.items() if doubt.applies(quality[doubt.number][row])]
        verdict[row] = ", ".join(words) or SOUND
    return {"verdict": verdict} | quality


def _settled_from(run: RunParameters, settling: Settling) -> float:
    return math.nan if settling.start is None else settling.start / run.record.sampling_frequency


@lru_cache(maxsize=1)
def _usual_ranges() -> list[tuple[str, str, float, float]]:
    """Section, field, and lowest and highest usual size of what describes a machine; what may be zero has no
    lowest."""
    ranges = []
    for name in parameter_names():
        (section, field), quantity = name.split("."), parameter_quantity(name)
        if section in _MACHINE and quantity is not None and quantity.usual is not None:
            low, high = (parse_quantity(bound, quantity.unit) for bound in quantity.usual)
            ranges.append((section, field, low if quantity.above == 0.0 else 0.0, high))
    return ranges


def _unusual_share(run: RunParameters, damping_ratio: float) -> float:
    """By how much a parameter or the damping ratio misses its usual range."""
    share = max(0.0, 1.0 - damping_ratio / _USUAL_DAMPING_RATIO)
    for section, field, low, high in _usual_ranges():
        value = getattr(getattr(run, section), field)
        if isinstance(value, float) and value:
            size = abs(value)
            share = max(share, 1.0 - size / low if low else 0.0, 1.0 - high / size)
    return share


def _clipped_share(run: RunParameters, shown: NDArray[np.float64]) -> float:
    """Share of samples at an end of the range, or on the level of the converter that lies there."""
    sensor = run.pressure_1_sensor
    lowest = -math.inf if sensor.lowest is None else sensor.lowest
    highest = math.inf if sensor.highest is None else sensor.highest
    slack = 0.5 * sensor.resolution
    return float(np.mean((shown <= lowest + slack) | (shown >= highest - slack)))
