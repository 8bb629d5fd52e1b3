"""Shards: the results of one batch of runs, written whole by a worker."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import StoreError
from hydrofdi.store.files import open_for_reading, whole_file
from hydrofdi.store.names import FORMAT_VERSION, RUN_ID, STATUS, TIME, stored_variables

Columns = Mapping[str, NDArray[Any]]
"""Variable name → array with one row per run; and ``time`` → sampling instants [s]."""


@dataclass(frozen=True)
class ShardRow:
    """Where the results of a run lie.

    Attributes
    ----------
    path : Path
        The shard.
    row : int
        Row within it.
    status : str
        How the run ended.
    signals : str
        Which signals it holds, as in ``store.signals``.
    """

    path: Path
    row: int
    status: str
    signals: str


def shard_path(directory: Path, run_ids: Sequence[str]) -> Path:
    """File of the shard that holds these runs."""
    digest = hashlib.sha256("\n".join(run_ids).encode()).hexdigest()
    return directory / "shards" / f"{digest[:16]}.h5"


def write_shard(path: Path, columns: Columns, signals: str) -> None:
    """Write the results of a batch, whole or not at all.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    with whole_file(path) as aside, h5py.File(aside, "w") as file:
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["signals"] = signals
        for variable in stored_variables(signals):
            values = columns[variable.name]
            if variable.is_text:
                file.create_dataset(
                    variable.name, data=[str(text) for text in values], dtype=h5py.string_dtype()
                )
            else:
                file.create_dataset(variable.name, data=values)
        if signals != "none":
            file.create_dataset(TIME, data=columns[TIME])


def index_shards(directory: Path) -> dict[str, ShardRow]:
    """All runs that are stored below an experiment's folder, by identity.

    Files that cannot be read, or that another version wrote, hold nothing.
    """
    rows: dict[str, ShardRow] = {}
    for path in sorted((directory / "shards").glob("*.h5")):
        try:
            rows |= _shard_rows(path)
        except StoreError:
            continue
    return rows


def _shard_rows(path: Path) -> dict[str, ShardRow]:
    with open_for_reading(path) as file:
        if file.attrs.get("format_version") != FORMAT_VERSION:
            return {}
        signals = str(file.attrs["signals"])
        run_ids, statuses = file[RUN_ID].asstr()[:], file[STATUS].asstr()[:]
        return {
            run_id: ShardRow(path, row, status, signals)
            for row, (run_id, status) in enumerate(zip(run_ids, statuses, strict=True))
        }


def read_rows(rows: Sequence[ShardRow], name: str) -> Iterator[tuple[list[int], NDArray[Any]]]:
    """The values of a variable, shard by shard.

    Parameters
    ----------
    rows : sequence of ShardRow
    name : str
        Variable that the shards hold.

    Yields
    ------
    positions : list of int
        Positions in `rows`.
    values : ndarray
        One row per position.
    """
    by_path: dict[Path, list[int]] = {}
    for position, row in enumerate(rows):
        by_path.setdefault(row.path, []).append(position)
    for path, positions in by_path.items():
        with open_for_reading(path) as file:
            dataset = file[name].asstr() if h5py.check_string_dtype(file[name].dtype) else file[name]
            values = np.asarray(dataset[:])
            yield positions, values[[rows[position].row for position in positions]]
