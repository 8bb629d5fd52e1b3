"""Reading of experiment files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hydrofdi.config import ExperimentConfig
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.settings.messages import describe_error
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.files import open_for_reading
from hydrofdi.store.layout.names import (
    FORMAT_VERSION,
    OBSTACLE,
    PHASE,
    REPLICATE_OF,
    REPLICATED,
    REQUESTED,
    RUN,
    STATUS,
    TIME,
    VERDICT,
    Variable,
    axis_variable,
    stored_variables,
)
from hydrofdi.store.layout.outputs import is_output
from hydrofdi.store.layout.variables import held_values
from hydrofdi.store.layout.wavelet_numbers import wavelet_numbers
from hydrofdi.store.request import stored_experiment
from hydrofdi.store.results import MISSING
from hydrofdi.store.signals import signal_rows

_VERSION = "version_"
"""Prefix of the attributes that contain library versions."""


@dataclass(frozen=True)
class FileSignals:
    """Signals in an experiment file."""

    path: Path

    def read(self, name: str, position: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sampling instants [s] and a signal of one run, each of shape (n_time,)."""
        with open_for_reading(self.path) as file:
            if name not in file:
                raise StoreError(
                    f"{self.path}: contains no {name}; set store: {{signals: all}} and sweep again"
                )
            values = file[name]
            return np.asarray(file[TIME][:]), np.asarray(values[:] if values.ndim == 1 else values[position])

    def rows(self, names: Sequence[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; signals that the file lacks are omitted."""
        with open_for_reading(self.path) as file:
            return {name: signal_rows(file[name], positions) for name in names if name in file}


def read_experiment(path: Path) -> ExperimentData:
    """Read an experiment file; signals stay on disk.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        experiment = _configuration(path, file)
        asked = (*REQUESTED, REPLICATED) if REPLICATE_OF in file else REQUESTED
        stored = (*asked, *stored_variables("none", phases=PHASE in file))
        axes = {axis_variable(name) for name in experiment.varied_names}
        held = [name for name in file if name in axes or (is_output(name) and not file[name].is_scale)]
        variables = (*stored, *(Variable(name, (RUN,), "", "") for name in held))
        columns = {each.name: held_values(file, each, slice(None)) for each in variables}
        columns |= wavelet_numbers(columns)
        if len({len(values) for values in columns.values()}) != 1:
            raise StoreError(f"{path}: is damaged: its variables differ in their number of runs")
        versions = {
            name.removeprefix(_VERSION): str(value)
            for name, value in file.attrs.items()
            if name.startswith(_VERSION)
        }
        physics = int(file.attrs["physics_version"])
        configuration = json.loads(file.attrs["configuration"])
    remarks = tuple(
        f"Indicator {label} is omitted: {why}. Its values remain in the file."
        for label, why in experiment.indicator_choice.absent.items()
    )
    return ExperimentData(
        path, experiment, columns, versions, FileSignals(path), configuration, remarks, physics
    )


def _configuration(path: Path, file: h5py.File) -> ExperimentConfig:
    try:
        return stored_experiment(file.attrs["configuration"])
    except ValidationError as error:
        writer = file.attrs.get(f"{_VERSION}hydrofdi", "an unknown version")
        first = error.errors()[0]
        reason = ": ".join([".".join(map(str, first["loc"])), describe_error(first)]).removeprefix(": ")
        raise StoreError(
            f"{path}: its configuration is not readable (hydrofdi {writer} wrote it): {reason}"
        ) from None


def is_current(path: Path, experiment: ExperimentConfig) -> bool:
    """Whether an experiment file contains all runs of this exact configuration."""
    try:
        with _experiment_file(path) as file:
            same = file.attrs["configuration"] == experiment.model_dump_json()
            current = file.attrs["physics_version"] == PHYSICS_VERSION
            return bool(same and current and MISSING not in file[STATUS].asstr()[:])
    except StoreError:
        return False


def read_statuses(path: Path) -> list[str]:
    """Status of each run of an experiment file.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        return list(file[STATUS].asstr()[:])


def read_verdicts(path: Path) -> list[str]:
    """Quality verdict on each run of an experiment file; empty if the file has no verdicts.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        return list(file[VERDICT].asstr()[:]) if VERDICT in file else []


def read_obstacles(path: Path) -> dict[str, list[str]]:
    """Label of an indicator → why it could not measure each run; empty text if it could.

    Raises
    ------
    StoreError
        The file is missing, damaged, or of another version.
    """
    with _experiment_file(path) as file:
        return {
            name.removesuffix(OBSTACLE): list(file[name].asstr()[:])
            for name in file
            if name.endswith(OBSTACLE)
        }


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
