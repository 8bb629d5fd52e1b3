"""What moves the spools: the input voltage, and the spool positions that follow from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.input import InputConfig
from hydrofdi.config.run import RunConfig
from hydrofdi.simulation.kernel import advance_spools
from hydrofdi.simulation.lanes import SPOOL_WIDTH, SPOOLS


@dataclass(frozen=True)
class Drive:
    """Everything that determines a spool's motion within a batch; runs that agree in it share one spool."""

    input: InputConfig
    natural_frequency: float
    damping_ratio: float
    spool_gain: float

    @classmethod
    def of(cls, parameters: RunParameters) -> Drive:
        """The drive of a run."""
        valve = parameters.valve
        return cls(parameters.input, valve.natural_frequency, valve.damping_ratio, valve.spool_gain)


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
            return _random_steps(drive, run, steps)
        case "sine":
            wave = np.sin(2.0 * np.pi * time / drive.period)
        case "sweep":
            rise = (drive.end_frequency - 1.0 / drive.period) / (2.0 * run.duration)
            wave = np.sin(2.0 * np.pi * time * (1.0 / drive.period + rise * time))
        case "multisine":
            wave = _multisine(time / drive.period, drive.harmonics) / _peak(drive.harmonics)
    return drive.amplitude * wave


def _random_steps(drive: InputConfig, run: RunConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    hold = round(drive.period / run.step)
    levels = np.random.default_rng(drive.seed).uniform(-1.0, 1.0, -(-run.n_step // hold))
    voltage: NDArray[np.float64] = drive.amplitude * levels[steps // hold]
    return voltage


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
    """

    def __init__(self, drives: Sequence[Drive], run: RunConfig) -> None:
        self._run = run
        units = [drive.input.model_copy(update={"amplitude": 1.0}) for drive in drives]
        self._units = list(dict.fromkeys(units))
        self._first_drives = range(0, len(drives), SPOOL_WIDTH)
        padded = np.resize(np.arange(len(drives)), len(self._first_drives) * SPOOL_WIDTH)
        self._unit_of_spool = np.array([self._units.index(unit) for unit in units])[padded]
        self._amplitude = np.array([drive.input.amplitude for drive in drives])[padded]
        self._stages = np.empty((0, 4, padded.size))
        self._spools = np.zeros(len(self._first_drives), SPOOLS)
        for field, values in {
            "frequency": [2.0 * math.pi * drive.natural_frequency for drive in drives],
            "damping_ratio": [drive.damping_ratio for drive in drives],
            "gain": [drive.spool_gain for drive in drives],
        }.items():
            self._spools[field] = np.array(values)[padded].reshape(-1, SPOOL_WIDTH)

    def advance(self, first: int, n_step: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Advance all spools from step `first` on.

        Columns beyond the number of drives repeat the first ones.

        Returns
        -------
        voltage : ndarray, shape (n_step, n_column)
            Input of each step [V].
        stages : ndarray, shape (n_step, 4, n_column)
            Spool position at the four Runge-Kutta stages of each step [m]; valid until the next call.
        """
        steps = np.arange(first, first + n_step)
        units = np.column_stack([input_voltage(unit, self._run, steps) for unit in self._units])
        voltage = self._amplitude * np.take(units, self._unit_of_spool, axis=1)
        if self._stages.shape[0] < n_step:
            self._stages = np.empty((n_step, 4, voltage.shape[1]))
        stages = self._stages[:n_step]
        for group, first_drive in enumerate(self._first_drives):
            advance_spools(self._spools[group : group + 1], voltage, self._run.step, first_drive, stages)
        return voltage, stages
