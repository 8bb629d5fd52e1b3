"""Reading of experiment files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
from pydantic import ValidationError

from hydrofdi.config import ExperimentConfig, RunTable
from hydrofdi.config.experiment import STORED
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.settings.messages import describe_error
from hydrofdi.store.experiment_data import MISSING, ExperimentData, ShardResults
from hydrofdi.store.experiment_file import columns_of
from hydrofdi.store.files import open_for_reading, reason, write_whole_text
from hydrofdi.store.layout import names
from hydrofdi.store.shard import values_in
from hydrofdi.store.signals import FileSignals

REQUEST_FILE = "experiment.json"
"""Name of the request file in an experiment's folder."""


def write_request(directory: Path, experiment: ExperimentConfig) -> None:
    """Store the resolved configuration of a sweep."""
    write_whole_text(directory / REQUEST_FILE, experiment.model_dump_json(indent=2) + "\n")


def require_same_experiment(directory: Path, experiment: ExperimentConfig) -> None:
    """Check that a folder does not contain an experiment with a different name."""
    if directory.exists() and not directory.is_dir():
        raise StoreError(f"{directory}: is a file, not a folder; give another 'out'")
    if not (directory / REQUEST_FILE).exists():
        return
    held = read_request(directory).name
    if held != experiment.name:
        raise StoreError(
            f"{directory}: contains the experiment {held!r}, not {experiment.name!r}; give another 'out'"
        )


def request_record(directory: Path) -> dict[str, Any]:
    """The latest request as written, in SI; empty if there is none."""
    path = directory / REQUEST_FILE
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError) as error:
        raise StoreError(f"{path}: cannot be read: {reason(error)}") from None


def read_request(directory: Path) -> ExperimentConfig:
    """The resolved configuration of the latest sweep on a folder."""
    record = request_record(directory)
    if not record:
        raise StoreError(f"{directory}: is not the folder of an experiment (it has no {REQUEST_FILE})")
    return stored_experiment(json.dumps(record), str(directory / REQUEST_FILE))


def stored_experiment(text: str, place: str) -> ExperimentConfig:
    """Parse a resolved configuration."""
    try:
        return ExperimentConfig.model_validate_json(text, context=STORED)
    except ValidationError as error:
        first = error.errors()[0]
        why = ": ".join(filter(None, (".".join(map(str, first["loc"])), describe_error(first))))
        raise StoreError(f"{place}: cannot be read: {why}") from None


_VERSION = "version_"
"""Prefix of the attributes that contain library versions."""


def read_experiment(path: Path) -> ExperimentData:
    """Read an experiment file; signals stay on disk."""
    with _experiment_file(path) as file:
        writer = file.attrs.get(f"{_VERSION}hydrofdi", "an unknown version")
        experiment = stored_experiment(
            file.attrs["configuration"], f"{path}: its configuration (hydrofdi {writer} wrote it)"
        )
        stored = (*names.REQUESTED, *names.stored_variables("none", phases=names.PHASE in file))
        required = [each.name for each in stored if each.name != names.REPLICATE_OF or each.name in file]
        axes = {names.axis_variable(name) for name in experiment.varied_names}
        others = [name for name in file if name in axes or ("." in name and not file[name].is_scale)]
        columns = {name: values_in(file, name) for name in (*required, *others)}
        columns |= names.wavelet_numbers(columns)
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


def is_current(path: Path, experiment: ExperimentConfig) -> bool:
    """Whether an experiment file contains all runs of this exact configuration."""
    try:
        with _experiment_file(path) as file:
            same = file.attrs["configuration"] == experiment.model_dump_json()
            current = file.attrs["physics_version"] == PHYSICS_VERSION
            return bool(same and current and MISSING not in file[names.STATUS].asstr()[:])
    except StoreError:
        return False


def read_texts(path: Path, name: str) -> dict[str, list[str]]:
    """Name → text of each run, of a variable, or of all variables with a suffix such as ``.obstacle``."""
    with _experiment_file(path) as file:
        found = [each for each in file if each == name or (name.startswith(".") and each.endswith(name))]
        return {each: list(file[each].asstr()[:]) for each in found}


@contextmanager
def _experiment_file(path: Path) -> Iterator[h5py.File]:
    with open_for_reading(path) as file:
        version = file.attrs.get("format_version")
        if version is None or "configuration" not in file.attrs:
            raise StoreError(f"{path}: is not an experiment file of hydrofdi")
        if version != names.FORMAT_VERSION:
            can = "no longer reads" if version < names.FORMAT_VERSION else "does not read yet"
            raise StoreError(
                f"{path}: has format version {version}, which this hydrofdi {can}"
                f" (it reads {names.FORMAT_VERSION}); sweep again into another folder"
            )
        yield file


def read_unfinished(
    path: Path,
    experiment: ExperimentConfig,
    table: RunTable,
    results: ShardResults,
    versions: Mapping[str, str],
) -> ExperimentData:
    """Read an experiment from its shards; runs without a result contain the reason."""
    columns = {variable.name: values for variable, values in columns_of(results, table).items()}
    return ExperimentData(path, experiment, columns, dict(versions), results)
