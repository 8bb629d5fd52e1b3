"""What moves the spools: the input voltage, and the spool positions that follow from it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.csv_input import parse_rows
from hydrofdi.config.input import InputConfig
from hydrofdi.config.run import RunConfig
from hydrofdi.simulation.lanes import SPOOL_WIDTH, SPOOLS
from hydrofdi.simulation.random_levels import random_levels
from hydrofdi.simulation.spool import advance_spools

_STEP_ROUNDING = 1e-6
"""A time so many steps after a step belongs to that step."""


@dataclass(frozen=True)
class Drive:
    """Everything that determines a spool's motion within a batch; runs that agree in it share one spool."""

    input: InputConfig
    frequency: float
    damping_ratio: float
    spool_gain: float
    position_limit: float
    speed_limit: float

    @classmethod
    def of(cls, parameters: RunParameters) -> Drive:
        """The drive of a run."""
        valve = parameters.valve
        return cls(
            parameters.input, valve.angular_frequency, valve.damping_ratio, valve.spool_gain,
            valve.position_limit, valve.speed_limit,
        )  # fmt: skip

    @property
    def is_limited(self) -> bool:
        """Whether position or speed of the spool saturates."""
        return min(self.position_limit, self.speed_limit) < math.inf


def input_voltage(drive: InputConfig, run: RunConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Voltage held over the given steps.

    Parameters
    ----------
    drive : InputConfig
    run : RunConfig
        Its step divides half of the period of a square, and the period of steps.
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        u [V].
    """
    time: NDArray[np.float64] = steps.astype(np.float64) * run.step
    wave: NDArray[np.float64]
    match drive.shape:
        case "square":
            half_period = round(drive.period / (2.0 * run.step))
            return np.where((steps // half_period) % 2 == 0, drive.amplitude, -drive.amplitude)
        case "steps":
            return drive.amplitude * random_levels(drive.seed, drive.period, run, steps)
        case "csv":
            return _held_rows(drive, run, steps)
        case "sine":
            wave = np.sin(2.0 * np.pi * time / drive.period)
        case "sweep":
            rise = (drive.end_frequency - 1.0 / drive.period) / (2.0 * run.duration)
            wave = np.sin(2.0 * np.pi * time * (1.0 / drive.period + rise * time))
        case "multisine":
            wave = _multisine(time / drive.period, drive.harmonics) / _peak(drive.harmonics)
    return drive.amplitude * wave


def position_reference(
    drive: InputConfig, amplitude: float, run: RunConfig, steps: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Position reference at the given steps, of the shape of an input [m], shape (n,).

    The rows of a file are positions, which no amplitude scales.
    """
    factor = 1.0 if drive.shape == "csv" else amplitude
    return factor * input_voltage(drive.model_copy(update={"amplitude": 1.0}), run, steps)


@lru_cache(maxsize=1024)
def largest_voltage(drive: InputConfig, run: RunConfig) -> float:
    """Largest abs(u) that an input may take in a record [V]."""
    if drive.shape not in ("steps", "csv"):
        return abs(drive.amplitude)
    return float(np.abs(input_voltage(drive, run, np.arange(run.n_step))).max())


def _held_rows(drive: InputConfig, run: RunConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    rows = parse_rows(drive.file or "")
    first_steps = np.ceil(rows.times / run.step - _STEP_ROUNDING)
    return rows.values[np.searchsorted(first_steps, steps, side="right") - 1]


def _multisine(phase: NDArray[np.float64], harmonics: int) -> NDArray[np.float64]:
    """Sum of harmonics with Schroeder's phases −πk(k−1)/n, which keep its peak low; `phase` in periods."""
    total = np.zeros_like(phase)
    for k in range(1, harmonics + 1):
        total += np.sin(2.0 * np.pi * k * phase - np.pi * k * (k - 1) / harmonics)
    return total


@cache
def _peak(harmonics: int) -> float:
    return float(np.abs(_multisine(np.arange(64 * harmonics) / (64 * harmonics), harmonics)).max())


class Spools:
    """The spools of several drives, advanced together chunk by chunk.

    Parameters
    ----------
    drives : sequence of Drive
        One spool each.
    run : RunConfig
        Step and length of the record.

    Attributes
    ----------
    columns : ndarray of int, shape (n_drive,)
        Column of each drive in the arrays that `advance` gives.
    """

    def __init__(self, drives: Sequence[Drive], run: RunConfig) -> None:
        self._run = run
        groups = list(_groups_of_spools(drives))
        spread = [int(k) for group in groups for k in np.resize(np.array(group), SPOOL_WIDTH)]
        self.columns = np.zeros(len(drives), dtype=np.int64)
        self.columns[spread[::-1]] = np.arange(len(spread))[::-1]
        self._is_limited = [drives[group[0]].is_limited or None for group in groups]
        padded = [drives[k] for k in spread]
        units = [drive.input.model_copy(update={"amplitude": 1.0}) for drive in padded]
        self._units = list(dict.fromkeys(units))
        places = {unit: place for place, unit in enumerate(self._units)}
        self._unit_of_spool = np.array([places[unit] for unit in units], dtype=np.int64)
        self._amplitude = np.array([drive.input.factor for drive in padded])
        self._stages = np.empty((0, 4, len(padded)))
        self._spools = np.zeros(len(groups), SPOOLS)
        for field, values in {
            "spool_frequency": [drive.frequency for drive in padded],
            "spool_damping_ratio": [drive.damping_ratio for drive in padded],
            "spool_gain": [drive.spool_gain for drive in padded],
            "spool_limit": [drive.position_limit for drive in padded],
            "spool_speed_limit": [drive.speed_limit for drive in padded],
        }.items():
            self._spools[field] = np.array(values).reshape(-1, SPOOL_WIDTH)

    def advance(self, first: int, n_step: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Advance all spools from step `first` on.

        Returns
        -------
        voltage : ndarray, shape (n_step, n_column)
            Input of each step [V].
        stages : ndarray, shape (n_step, 4, n_column)
            Spool position at the four Runge-Kutta stages of each step [m]; valid until the next call.
        """
        steps = np.arange(first, first + n_step)
        units = np.empty((n_step, len(self._units)))
        for column, unit in enumerate(self._units):
            units[:, column] = input_voltage(unit, self._run, steps)
        voltage = self._amplitude * np.take(units, self._unit_of_spool, axis=1)
        if len(self._stages) < n_step:
            self._stages = np.empty((n_step, 4, voltage.shape[1]))
        stages = self._stages[:n_step]
        for group, is_limited in enumerate(self._is_limited):
            advance_spools(
                self._spools[group : group + 1], voltage, self._run.step, group * SPOOL_WIDTH, stages,
                is_limited,
            )  # fmt: skip
        return voltage, stages


def _groups_of_spools(drives: Sequence[Drive]) -> Iterator[list[int]]:
    """Positions of drives that are advanced together, SPOOL_WIDTH at most; all of them limited or none."""
    for kind in (False, True):
        members = [k for k, drive in enumerate(drives) if drive.is_limited is kind]
        for first in range(0, len(members), SPOOL_WIDTH):
            yield members[first : first + SPOOL_WIDTH]
