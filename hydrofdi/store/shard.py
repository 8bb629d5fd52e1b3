"""Shards: the results of one batch of runs, written atomically and named by a hash of their content."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import StoreConfig
from hydrofdi.errors import StoreError
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.files import LIBRARY_VERSIONS, open_for_reading, whole_file
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import Variable
from hydrofdi.store.signals import create_signal, write_block

if TYPE_CHECKING:
    import h5py

Columns = Mapping[str, NDArray[Any]]
"""Variable name → array with one row per run; ``time`` → sampling instants [s]."""

SHARDS = "shards"
"""Folder of the shards within an experiment's folder."""


def write_shard(directory: Path, columns: Columns, store: StoreConfig) -> Path:
    """Write the results of a batch atomically into an experiment's folder."""
    return _place_shard(directory, lambda aside: _write_file(aside, columns, store))


def store_shard_bytes(directory: Path, content: bytes) -> Path:
    """Store the content of a shard that was made elsewhere, and return its path."""
    return _place_shard(directory, lambda aside: aside.write_bytes(content))


def _place_shard(directory: Path, write: Callable[[Path], object]) -> Path:
    path = directory / SHARDS / "new.h5"
    with whole_file(path, lambda: path) as aside:
        write(aside)
        path = path.with_name(f"{content_digest(aside)}.h5")
    return path


def _write_file(path: Path, columns: Columns, store: StoreConfig) -> None:
    import h5py

    has_phases = names.SETTLED_PHASE_DETAIL_RMS in columns
    with h5py.File(path, "w", libver=LIBRARY_VERSIONS) as file:
        file.attrs["format_version"] = names.FORMAT_VERSION
        file.attrs["physics_version"] = PHYSICS_VERSION
        file.attrs["signals"] = store.signals
        file.attrs["dtype"] = store.dtype
        outputs = [
            Variable(name, (names.RUN,), "", "")
            for name, values in columns.items()
            if "." in name and not names.is_needless(name, values)
        ]
        for variable in (*names.stored_variables(store.signals, phases=has_phases), *outputs):
            if variable.name == names.OIL_TEMPERATURE and variable.name not in columns:
                continue
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


def content_digest(path: Path) -> str:
    """The first 32 hexadecimal digits of the SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def read_content(path: Path, *, check: bool = True) -> dict[str, Any]:
    """What a shard contains, as the index has it, after checking it against its name if `check` is true."""
    if check and content_digest(path) != path.stem:
        raise StoreError(f"{path}: is damaged: its content does not match its name")
    with open_for_reading(path) as file:
        if file.attrs["format_version"] != names.FORMAT_VERSION:
            raise StoreError(f"{path}: has format version {file.attrs['format_version']}")
        columns = {"run_ids": names.RUN_ID, "record_ids": names.RECORD_ID, "statuses": names.STATUS}
        return {
            **{key: values_in(file, name).tolist() for key, name in columns.items()},
            "signals": str(file.attrs["signals"]),
            "dtype": str(file.attrs["dtype"]),
            "physics_version": int(file.attrs["physics_version"]),
        }


def values_in(file: h5py.File, name: str, rows: slice = np.s_[:]) -> NDArray[Any]:
    """Rows of a variable."""
    import h5py

    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or not dataset.shape:
        raise KeyError(f"{name} is not a variable with one row per run")
    is_text = h5py.check_string_dtype(dataset.dtype)
    return np.asarray(dataset.asstr()[rows] if is_text else dataset[rows])


def read_rows(path: Path, variables: Iterable[str], rows: Sequence[int]) -> dict[str, NDArray[Any]]:
    """Rows of those of some variables that a shard contains, by name."""
    first, inside = min(rows), slice(min(rows), max(rows) + 1)
    with open_for_reading(path) as file:
        return {
            name: values_in(file, name, inside)[np.asarray(rows) - first]
            for name in variables
            if name in file
        }
