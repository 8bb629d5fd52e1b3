"""External inputs of a batch of runs: spools or position references, and load forces."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.drive import InputConfig, RecordConfig
from hydrofdi.config.sections.machine import LoadConfig
from hydrofdi.simulation.drive import Drive, Spools, position_reference, random_levels

SignalByName = Callable[[str], NDArray[np.float64]]
"""Function from the name of a signal to its values, shape (n_step, n_lane); only the first lanes are used."""

Reader = Callable[[int, SignalByName], None]
"""Function that reads a block of steps, given the number of its first step; blocks are contiguous."""


class Tap(Protocol):
    """Interface that reads runs of a batch at every step; a record of all steps is never stored."""

    def wants(self, position: int) -> bool:
        """Whether to read the run at a position of the batch."""

    def feedback_noise(self, position: int) -> NDArray[np.float64] | None:
        """Noise of the position that the controller of a run reads, at each of its samples [m], or None."""

    def reader(self, positions: Sequence[int]) -> Reader:
        """Reader of the runs at these positions, which are in the first lanes."""


Array = NDArray[np.float64]

_Value = TypeVar("_Value", bound=Hashable)


class Chunk(NamedTuple):
    """Inputs of some steps; runs with equal inputs share a column.

    Attributes
    ----------
    voltage : ndarray, shape (n_step, n_drive)
        Input of the spools in open loop [V].
    stages : ndarray, shape (n_step, 4, n_drive)
        Positions of the spools in open loop [m]; valid until the next chunk.
    references : ndarray, shape (n_step, 2, n_reference)
        Position references of the runs in closed loop, and the errors of the measured positions [m].
    loads : ndarray, shape (n_step, n_load)
        Load forces [N].
    """

    voltage: Array
    stages: Array
    references: Array
    loads: Array

    def part(self, first: int, last: int) -> Chunk:
        """Inputs of some of the steps."""
        return Chunk(*(values[first:last] for values in self))


class Inputs:
    """Inputs of a batch of runs.

    Parameters
    ----------
    record : RecordConfig
        Step and length of their record.
    tap : Tap, optional
        Supplies the noise of the positions that controllers read; by default none.

    Attributes
    ----------
    is_closed : ndarray of bool, shape (n_run,)
        Whether a controller drives the valve.
    n_drive : int
        Number of spools in open loop.
    column_of_run, load_of_run : ndarray of int, shape (n_run,)
        Column of each run in the drives or references, and in the loads.
    """

    def __init__(self, runs: Sequence[RunParameters], record: RecordConfig, tap: Tap | None = None) -> None:
        self._record = record
        self.is_closed = np.array([parameters.control.is_closed for parameters in runs])
        keys = [
            _reference_of(one, k) if one.control.is_closed else Drive.of(one) for k, one in enumerate(runs)
        ]
        drives = _places(key for key in keys if isinstance(key, Drive))
        references = _places(key for key in keys if not isinstance(key, Drive))
        loads = _places(parameters.load for parameters in runs)
        self._spools, self.n_drive = Spools(list(drives), record), len(drives)
        self._shared = (
            _whole_record(*drives, record)
            if len(drives) == 1 and record.n_step <= _MOST_SHARED_STEPS
            else None
        )
        self._references, self._loads = list(references), list(loads)
        self._readers = {
            k: (runs[k], tap.feedback_noise(k) if tap else None) for *_, k in references if k >= 0
        }
        self.column_of_run = np.array([
            self._spools.columns[drives[key]] if isinstance(key, Drive) else references[key] for key in keys
        ])  # fmt: skip
        self.load_of_run = np.array([loads[parameters.load] for parameters in runs])

    def advance(self, first: int, n_step: int) -> Chunk:
        """Inputs from step `first` on."""
        steps = np.arange(first, first + n_step)
        if self._shared:
            voltage, stages = (values[first : first + n_step] for values in self._shared)
        else:
            voltage, stages = self._spools.advance(first, n_step)
        references = np.zeros((n_step, 2, len(self._references)))
        for column, (drive, amplitude, reader) in enumerate(self._references):
            references[:, 0, column] = position_reference(drive, amplitude, self._record, steps)
            if reader in self._readers:
                run, noise = self._readers[reader]
                references[:, 1, column] = reading_errors(run, steps, noise)
        loads = np.column_stack([load_force(load, self._record, steps) for load in self._loads])
        return Chunk(voltage, stages, references, loads)


_MOST_SHARED_STEPS = 500_000
"""Steps of the longest record whose drive is kept; it takes 20 MB."""


@lru_cache(maxsize=1)
def _whole_record(drive: Drive, record: RecordConfig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Voltage and stages of one drive over a record, computed once for all batches of a sweep."""
    return Spools([drive], record).advance(0, record.n_step)


def _reference_of(parameters: RunParameters, position: int) -> tuple[InputConfig, float, int]:
    """Key of the references of a run: equal for runs that share them, unique for measured feedback."""
    reader = position if parameters.control.is_measured else -1
    return parameters.input, parameters.control.amplitude, reader


def _places(values: Iterable[_Value]) -> dict[_Value, int]:
    """Distinct values, each with its index."""
    return {value: place for place, value in enumerate(dict.fromkeys(values))}


_STREAM = 1
"""Random stream of the load, independent of an input with the same seed."""


def load_force(load: LoadConfig, record: RecordConfig, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Force against positive motion, held over the given steps.

    Parameters
    ----------
    record : RecordConfig
        Its step divides the period of a pseudo-random force.
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.

    Returns
    -------
    ndarray, shape (n,)
        F_L [N].
    """
    if not load.random_force:
        return np.full(steps.shape, load.constant_force)
    levels = random_levels((load.seed, _STREAM), load.random_period, record, steps)
    return load.constant_force + load.random_force * levels


def steps_per_control(run: RunParameters) -> int:
    """Number of steps per sample of the controller."""
    return round(run.control.sample_time / run.record.step)


def reading_errors(
    run: RunParameters, steps: NDArray[np.int64], noise: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Error of the position before the converter, at the given steps.

    Parameters
    ----------
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.
    noise : ndarray, shape (n_control,), optional
        Noise at each sample of the controller [m]; by default none.

    Returns
    -------
    ndarray, shape (n,)
        Bias, drift and noise [m]; zero if the controller reads the true position.
    """
    if not run.control.is_measured:
        return np.zeros(steps.shape)
    sensor = run.position_sensor
    errors = np.asarray(sensor.bias + sensor.drift * run.record.step * steps, dtype=float)
    # The noise of a sample is held until the controller takes the next.
    return errors if noise is None else errors + noise[steps // steps_per_control(run)]
