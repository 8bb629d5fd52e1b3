"""Shards: the results of one batch of runs, written atomically and named by a hash of their content."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import StoreConfig
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import LIBRARY_VERSIONS, open_for_reading, reason, sync_folder
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import Variable, stored_variables
from hydrofdi.store.layout.outputs import is_needless, is_output
from hydrofdi.store.signals import create_signal, write_block

if TYPE_CHECKING:
    from hydrofdi.store.index import StoredRun

Columns = Mapping[str, NDArray[Any]]
"""Variable name → array with one row per run; ``time`` → sampling instants [s]."""

SHARDS = "shards"
"""Folder of the shards within an experiment's folder."""


@dataclass(frozen=True)
class ShardContent:
    """Description of the content of a shard.

    Attributes
    ----------
    run_ids, record_ids, statuses : tuple of str
        One per row.
    signals, dtype : str
        As in the ``store`` section.
    physics_version : int
    """

    run_ids: tuple[str, ...]
    record_ids: tuple[str, ...]
    statuses: tuple[str, ...]
    signals: str
    dtype: str
    physics_version: int


def write_shard(directory: Path, columns: Columns, store: StoreConfig) -> Path:
    """Write the results of a batch atomically into an experiment's folder.

    Returns
    -------
    Path
        Path of the shard; its name is the hash of its content.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    return _place_shard(directory, lambda aside: _write_file(aside, columns, store))


def store_shard_bytes(directory: Path, content: bytes) -> Path:
    """Store the content of a shard that was made elsewhere, and return its path.

    Raises
    ------
    StoreError
        The file cannot be written.
    """

    def write(aside: Path) -> None:
        aside.write_bytes(content)

    return _place_shard(directory, write)


def _place_shard(directory: Path, write: Callable[[Path], None]) -> Path:
    folder = directory / SHARDS
    aside = folder / f".{os.getpid()}.part"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write(aside)
        path = folder / f"{content_digest(aside)}.h5"
        with open(aside, "rb") as file:
            os.fsync(file.fileno())
        os.replace(aside, path)
        sync_folder(folder)
    except (OSError, RuntimeError) as error:
        raise StoreError(f"{folder}: cannot be written: {reason(error)}") from None
    finally:
        if aside.exists():
            aside.unlink()
    return path


def _write_file(path: Path, columns: Columns, store: StoreConfig) -> None:
    has_phases = names.SETTLED_PHASE_DETAIL_RMS in columns
    with h5py.File(path, "w", libver=LIBRARY_VERSIONS) as file:
        file.attrs["format_version"] = names.FORMAT_VERSION
        file.attrs["physics_version"] = PHYSICS_VERSION
        file.attrs["signals"] = store.signals
        file.attrs["dtype"] = store.dtype
        for variable in (*stored_variables(store.signals, phases=has_phases), *_outputs(columns)):
            values = columns[variable.name]
            if variable.is_text:
                texts = [str(text) for text in values]
                file.create_dataset(variable.name, data=texts, dtype=h5py.string_dtype())
            elif variable.is_signal:
                still = values[0, 0] if variable.is_mostly_still else None
                write_block(create_signal(file, variable.name, values.shape, store, still), 0, values)
            else:
                file.create_dataset(variable.name, data=values)
        if store.signals != "none":
            file.create_dataset(names.TIME, data=columns[names.TIME])


def _outputs(columns: Columns) -> list[Variable]:
    """Variables of indicator outputs among the columns."""
    return [
        Variable(name, (names.RUN,), "", "")
        for name, values in columns.items()
        if is_output(name) and not is_needless(name, values)
    ]


def content_digest(path: Path) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def read_content(path: Path, *, check: bool = True) -> ShardContent:
    """Read the description of a shard, after checking its content against its name if `check` is true.

    Raises
    ------
    StoreError
        The shard is damaged, or has another format version.
    """
    if check and content_digest(path) != path.stem:
        raise StoreError(f"{path}: is damaged: its content does not match its name")
    with open_for_reading(path) as file:
        if file.attrs["format_version"] != names.FORMAT_VERSION:
            raise StoreError(f"{path}: has format version {file.attrs['format_version']}")
        return ShardContent(
            run_ids=tuple(file[names.RUN_ID].asstr()[:]),
            record_ids=tuple(file[names.RECORD_ID].asstr()[:]),
            statuses=tuple(file[names.STATUS].asstr()[:]),
            signals=str(file.attrs["signals"]),
            dtype=str(file.attrs["dtype"]),
            physics_version=int(file.attrs["physics_version"]),
        )


def held_values(file: h5py.File, variable: Variable, rows: slice) -> NDArray[Any]:
    """Rows of a variable.

    Raises
    ------
    KeyError
        The file lacks it.
    """
    dataset = file[variable.name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{dataset.name} is not a variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


def read_variables(
    path: Path, variables: Collection[Variable], rows: NDArray[np.int64]
) -> dict[str, NDArray[Any]]:
    """Rows of variables of a shard, by name; a variable that it lacks has size zero beyond the rows."""
    with open_for_reading(path) as file:
        return {variable.name: _read_rows(file, variable, rows) for variable in variables}


def _read_rows(file: h5py.File, variable: Variable, rows: NDArray[np.int64]) -> NDArray[Any]:
    first, last = int(rows.min()), int(rows.max())
    if not variable.is_optional or variable.name in file:
        return held_values(file, variable, slice(first, last + 1))[rows - first]
    return variable.blank(len(rows), *[0] * (len(variable.dimensions) - 1))


def read_records(places: Sequence[StoredRun], signals: Collection[str], n_time: int) -> Columns:
    """Read stored records: the requested signals and their metadata.

    Parameters
    ----------
    places : sequence
        Location of each record; signals of failed records may be missing.
    signals : collection of str
    n_time : int
        Number of samples of each signal.
    """
    variables = [
        variable
        for variable in stored_variables("all")
        if (variable.name in signals if variable.is_signal else variable.name not in names.FEATURES)
    ]
    columns: dict[str, NDArray[Any]] = {}
    rows_in: dict[Path, list[int]] = {}
    for position, place in enumerate(places):
        rows_in.setdefault(place.shard, []).append(position)
    for shard, positions in rows_in.items():
        held = read_variables(shard, variables, np.array([places[k].row for k in positions]))
        for variable in variables:
            size = [n_time] if variable.is_signal else []
            whole = columns.setdefault(variable.name, variable.blank(len(places), *size))
            if held[variable.name].shape[1:] == whole.shape[1:]:
                whole[positions] = held[variable.name]
    return columns


def held_names(path: Path) -> set[str]:
    """Names of the variables in a shard."""
    with open_for_reading(path) as file:
        return set(file)
