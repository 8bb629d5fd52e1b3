"""Experiment files read back."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import open_for_reading
from hydrofdi.store.names import FORMAT_VERSION, PHASE, REQUESTED, RUN_ID, STATUS, TIME, stored_variables
from hydrofdi.store.results import MISSING
from hydrofdi.store.variables import absent_values, holds_variable

_VERSION = "version_"
"""Prefix of the attributes that hold library versions."""


class SignalSource(Protocol):
    """Where the signals of an experiment lie."""

    def read(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, each of shape (n_time,)."""
        ...


@dataclass(frozen=True)
class ExperimentData:
    """An experiment and its results.

    Attributes
    ----------
    path : Path
        The experiment file.
    experiment : ExperimentConfig
        The configuration as it was resolved.
    columns : dict
        Variable name → array with one row per run, signals left out.
    versions : dict
        Library → version that the results were made with.
    signals : SignalSource
        Where the signals lie.
    """

    path: Path
    experiment: ExperimentConfig
    columns: dict[str, NDArray[Any]]
    versions: dict[str, str]
    signals: SignalSource

    @cached_property
    def table(self) -> RunTable:
        """The runs, expanded again from the configuration."""
        return expand_runs(self.experiment)

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return len(self.columns[RUN_ID])

    def signal(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, each of shape (n_time,).

        Raises
        ------
        StoreError
            The experiment did not store it.
        """
        return self.signals.read(name, position)


@dataclass(frozen=True)
class FileSignals:
    """Signals in an experiment file."""

    path: Path

    def read(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants and a signal of one run."""
        with open_for_reading(self.path) as file:
            if name not in file:
                raise StoreError(f"{self.path}: holds no {name}; set store: {{signals: all}} and sweep again")
            values = file[name]
            return np.asarray(file[TIME][:]), np.asarray(values[:] if values.ndim == 1 else values[position])


def read_experiment(path: Path) -> ExperimentData:
    """An experiment file, signals left on disk.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        try:
            experiment = ExperimentConfig.model_validate_json(file.attrs["configuration"])
        except ValidationError as error:
            raise StoreError(f"{path}: its configuration is not readable: {error.title}") from None
        columns = {
            variable.name: _values(file, variable.name)
            for variable in (*REQUESTED, *stored_variables("none", phases=PHASE in file))
        }
        if len({len(values) for values in columns.values()}) != 1:
            raise StoreError(f"{path}: is damaged: its variables differ in their number of runs")
        versions = {
            name.removeprefix(_VERSION): str(value)
            for name, value in file.attrs.items()
            if name.startswith(_VERSION)
        }
    return ExperimentData(path, experiment, columns, versions, FileSignals(path))


def is_current(path: Path, experiment: ExperimentConfig) -> bool:
    """Whether an experiment file holds all runs of just this configuration."""
    try:
        with _experiment_file(path) as file:
            same = file.attrs["configuration"] == experiment.model_dump_json()
            current = file.attrs["physics_version"] == PHYSICS_VERSION
            return bool(same and current and MISSING not in file[STATUS].asstr()[:])
    except StoreError:
        return False


def read_statuses(path: Path) -> list[str]:
    """How the runs of an experiment file ended.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        return list(file[STATUS].asstr()[:])


@contextmanager
def _experiment_file(path: Path) -> Iterator[h5py.File]:
    with open_for_reading(path) as file:
        version = file.attrs.get("format_version")
        if version is None or "configuration" not in file.attrs:
            raise StoreError(f"{path}: is not an experiment file of hydrofdi")
        if version != FORMAT_VERSION:
            raise StoreError(f"{path}: has format version {version}; this hydrofdi reads {FORMAT_VERSION}")
        yield file


def _values(file: h5py.File, name: str) -> NDArray[Any]:
    if not holds_variable(file, name):
        return absent_values(file, name)
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is no variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[:] if is_text else dataset[:])
