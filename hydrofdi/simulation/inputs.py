"""What acts on the runs of a batch from outside: spools or position references, and load forces."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.input import InputConfig
from hydrofdi.config.sections.record import RecordConfig
from hydrofdi.simulation.drive import Drive, Spools, position_reference
from hydrofdi.simulation.load import load_force

Array = NDArray[np.float64]

_Value = TypeVar("_Value", bound=Hashable)


class Chunk(NamedTuple):
    """Inputs of some steps; one column for runs that share one.

    Attributes
    ----------
    voltage : ndarray, shape (n_step, n_drive)
        Input of the spools in open loop [V].
    stages : ndarray, shape (n_step, 4, n_drive)
        Positions of the spools in open loop [m]; valid until the next chunk.
    references : ndarray, shape (n_step, 1, n_reference)
        Position references of the runs in closed loop [m].
    loads : ndarray, shape (n_step, n_load)
        Load forces [N].
    """

    voltage: Array
    stages: Array
    references: Array
    loads: Array

    def part(self, first: int, last: int) -> Chunk:
        """The inputs of some of the steps."""
        return Chunk(*(values[first:last] for values in self))


class Inputs:
    """The inputs of a batch of runs.

    Parameters
    ----------
    runs : sequence of RunParameters
    record : RecordConfig
        Step and length of their record.

    Attributes
    ----------
    is_closed : ndarray of bool, shape (n_run,)
        Whether a controller drives the valve.
    n_drive : int
        Number of spools in open loop.
    column_of_run, load_of_run : ndarray of int, shape (n_run,)
        Column of each run in the drives or references, and in the loads.
    """

    def __init__(self, runs: Sequence[RunParameters], record: RecordConfig) -> None:
        self._record = record
        self.is_closed = np.array([parameters.control.is_closed for parameters in runs])
        keys = [_reference_of(one) if one.control.is_closed else Drive.of(one) for one in runs]
        drives = _places(key for key in keys if isinstance(key, Drive))
        references = _places(key for key in keys if not isinstance(key, Drive))
        loads = _places(parameters.load for parameters in runs)
        self._spools, self.n_drive = Spools(list(drives), record), len(drives)
        self._references, self._loads = list(references), list(loads)
        self.column_of_run = np.array([
            self._spools.columns[drives[key]] if isinstance(key, Drive) else references[key] for key in keys
        ])  # fmt: skip
        self.load_of_run = np.array([loads[parameters.load] for parameters in runs])

    def advance(self, first: int, n_step: int) -> Chunk:
        """The inputs from step `first` on."""
        steps = np.arange(first, first + n_step)
        voltage, stages = self._spools.advance(first, n_step)
        references = np.empty((n_step, 1, len(self._references)))
        for column, (drive, amplitude) in enumerate(self._references):
            references[:, 0, column] = position_reference(drive, amplitude, self._record, steps)
        loads = np.column_stack([load_force(load, self._record, steps) for load in self._loads])
        return Chunk(voltage, stages, references, loads)


def _reference_of(parameters: RunParameters) -> tuple[InputConfig, float]:
    return parameters.input, parameters.control.amplitude


def _places(values: Iterable[_Value]) -> dict[_Value, int]:
    """The distinct values, each with its place."""
    return {value: place for place, value in enumerate(dict.fromkeys(values))}
