"""Experiment files read back."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hydrofdi.config import ExperimentConfig
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.settings.mistakes import describe_error
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.files import open_for_reading
from hydrofdi.store.names import (
    FORMAT_VERSION,
    PHASE,
    REPLICATE_OF,
    REPLICATED,
    REQUESTED,
    STATUS,
    TIME,
    axis_variable,
    stored_variables,
)
from hydrofdi.store.results import MISSING
from hydrofdi.store.signals import signal_rows
from hydrofdi.store.variables import absent_values, holds_variable

_VERSION = "version_"
"""Prefix of the attributes that hold library versions."""


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

    def rows(self, names: Sequence[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; those that the file lacks are left out."""
        with open_for_reading(self.path) as file:
            return {name: signal_rows(file[name], positions) for name in names if name in file}


def read_experiment(path: Path) -> ExperimentData:
    """An experiment file, signals left on disk.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        experiment = _configuration(path, file)
        asked = (*REQUESTED, REPLICATED) if REPLICATE_OF in file else REQUESTED
        stored = (*asked, *stored_variables("none", phases=PHASE in file))
        swept = {axis_variable(name) for name in (*experiment.ensemble.names, *experiment.sweep.names)}
        columns = {name: _values(file, name) for name in swept if name in file}
        columns |= {variable.name: _values(file, variable.name) for variable in stored}
        if len({len(values) for values in columns.values()}) != 1:
            raise StoreError(f"{path}: is damaged: its variables differ in their number of runs")
        versions = {
            name.removeprefix(_VERSION): str(value)
            for name, value in file.attrs.items()
            if name.startswith(_VERSION)
        }
        physics = int(file.attrs["physics_version"])
        configuration = json.loads(file.attrs["configuration"])
    return ExperimentData(
        path, experiment, columns, versions, FileSignals(path), configuration, physics_version=physics
    )


def _configuration(path: Path, file: h5py.File) -> ExperimentConfig:
    try:
        return ExperimentConfig.model_validate_json(file.attrs["configuration"])
    except ValidationError as error:
        writer = file.attrs.get(f"{_VERSION}hydrofdi", "an unknown version")
        first = error.errors()[0]
        reason = ": ".join([".".join(map(str, first["loc"])), describe_error(first)]).removeprefix(": ")
        raise StoreError(
            f"{path}: its configuration is not readable (hydrofdi {writer} wrote it): {reason}"
        ) from None


def is_current(path: Path, experiment: ExperimentConfig) -> bool:
    """Whether an experiment file holds all runs of just this configuration."""
    try:
        with _experiment_file(path) as file:
            same = file.attrs["configuration"] == experiment.model_dump_json()
            current = file.attrs["physics_version"] == PHYSICS_VERSION
            return bool(same and current and MISSING not in file[STATUS].asstr()[:])
    except StoreError:
        return False


def is_experiment_file(path: Path) -> bool:
    """Whether an HDF5 file is an experiment file of hydrofdi, of whatever version.

    Raises
    ------
    StoreError
        It is damaged.
    """
    with open_for_reading(path) as file:
        return "format_version" in file.attrs and "configuration" in file.attrs


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
            can = "no longer reads" if version < FORMAT_VERSION else "does not read yet"
            raise StoreError(
                f"{path}: has format version {version}, which this hydrofdi {can}"
                f" (it reads {FORMAT_VERSION}); sweep again into another folder"
            )
        yield file


def _values(file: h5py.File, name: str) -> NDArray[Any]:
    if not holds_variable(file, name):
        return absent_values(file, name)
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is no variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[:] if is_text else dataset[:])
