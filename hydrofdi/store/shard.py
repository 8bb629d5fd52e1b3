"""Shards: the results of one batch of runs, written whole and named by their content."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.store import StoreConfig
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import LIBRARY_VERSIONS, open_for_reading, reason, sync_folder
from hydrofdi.store.names import FORMAT_VERSION, PHASE_DETAIL_RMS, RUN_ID, STATUS, TIME, stored_variables
from hydrofdi.store.signals import create_signal, write_block
from hydrofdi.store.variables import absent_values, holds_variable

Columns = Mapping[str, NDArray[Any]]
"""Variable name → array with one row per run; and ``time`` → sampling instants [s]."""

SHARDS = "shards"
"""Folder of the shards within an experiment's folder."""


@dataclass(frozen=True)
class ShardContent:
    """What a shard holds.

    Attributes
    ----------
    run_ids, statuses : tuple of str
        One per row.
    signals, dtype : str
        As in the ``store`` section.
    physics_version : int
    """

    run_ids: tuple[str, ...]
    statuses: tuple[str, ...]
    signals: str
    dtype: str
    physics_version: int


def write_shard(directory: Path, columns: Columns, store: StoreConfig) -> Path:
    """Write the results of a batch below an experiment's folder, whole or not at all.

    Returns
    -------
    Path
        The shard; its name is the hash of its content.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    return _place_shard(directory, lambda aside: _write_file(aside, columns, store))


def store_shard_bytes(directory: Path, content: bytes) -> Path:
    """Place the content of a shard that was made elsewhere.

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
    with h5py.File(path, "w", libver=LIBRARY_VERSIONS) as file:
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["physics_version"] = PHYSICS_VERSION
        file.attrs["signals"] = store.signals
        file.attrs["dtype"] = store.dtype
        for variable in stored_variables(store.signals, phases=PHASE_DETAIL_RMS in columns):
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
            file.create_dataset(TIME, data=columns[TIME])


def content_digest(path: Path) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def read_content(path: Path, *, check: bool = True) -> ShardContent:
    """What a shard holds; its content is checked against its name unless that is not wanted.

    Raises
    ------
    StoreError
        It is damaged, or of another format version.
    """
    if check and content_digest(path) != path.stem:
        raise StoreError(f"{path}: is damaged: its content does not fit its name")
    with open_for_reading(path) as file:
        if file.attrs["format_version"] != FORMAT_VERSION:
            raise StoreError(f"{path}: has format version {file.attrs['format_version']}")
        return ShardContent(
            run_ids=tuple(file[RUN_ID].asstr()[:]),
            statuses=tuple(file[STATUS].asstr()[:]),
            signals=str(file.attrs["signals"]),
            dtype=str(file.attrs["dtype"]),
            physics_version=int(file.attrs["physics_version"]),
        )


def read_variables(path: Path, names: Collection[str], rows: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """Rows of variables of a shard; NaN where one was added after the shard was written."""
    with open_for_reading(path) as file:
        return {name: _read_rows(file, name, rows) for name in names}


def _read_rows(file: h5py.File, name: str, rows: NDArray[np.int64]) -> NDArray[Any]:
    if not holds_variable(file, name):
        return absent_values(file, name)[rows]
    dataset = file[name]
    if h5py.check_string_dtype(dataset.dtype):
        return np.asarray(dataset.asstr()[:])[rows]
    first, last = int(rows.min()), int(rows.max())
    return np.asarray(dataset[first : last + 1])[rows - first]


def lacks_variable(path: Path, name: str) -> bool:
    """Whether a shard was written before a variable was added."""
    with open_for_reading(path) as file:
        return not holds_variable(file, name)
