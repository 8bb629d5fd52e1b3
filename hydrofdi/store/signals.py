"""Signals in HDF5 files: layout of their rows, and copying from one file to another."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import StoreConfig
from hydrofdi.store.files import open_for_reading
from hydrofdi.store.layout.names import TIME

if TYPE_CHECKING:
    import h5py

_BLOCK_BYTES = 1_000_000
"""Approximate size of a block in memory, so that it fits the processor cache [bytes]."""


class Chunk(NamedTuple):
    """One row of a signal as stored in a file, compressed or not."""

    filter_mask: int
    content: bytes


Block = NDArray[Any] | Chunk
"""Rows of a signal that are being copied: an array of shape (n_row, n_time), or one stored row."""


def create_signal(
    file: h5py.File, name: str, shape: tuple[int, int], store: StoreConfig, still: float | None = None
) -> h5py.Dataset:
    """Create a signal of shape (n_run, n_time); rows that are constant at `still` take no space."""
    options: dict[str, Any] = {}
    if still is not None:
        options = {"chunks": (1, shape[1]), "fillvalue": still}
    if store.compression != "none":
        options |= {"chunks": (1, shape[1]), "compression": store.compression, "shuffle": True}
    if store.compression == "gzip":
        options["compression_opts"] = 4
    return file.create_dataset(name, shape, store.dtype, **options)


def read_blocks(source: h5py.Dataset, row: int, n_row: int, target: h5py.Dataset) -> Iterator[Block]:
    """Rows of a signal, compressed if the target has its layout; write each block before the next."""
    if _laid_out_alike(source, target):
        for k in range(row, row + n_row):
            yield _read_chunk(source, k)
        return
    n_time = source.shape[1]
    buffer = np.empty((_rows_per_block(n_time), n_time), target.dtype)
    for first in range(row, row + n_row, len(buffer)):
        block = buffer[: min(len(buffer), row + n_row - first)]
        source.read_direct(block, np.s_[first : first + len(block)])
        yield block
    _drop_from_page_cache(source, row, n_row)


def lacking_blocks(n_row: int, target: h5py.Dataset) -> Iterator[Block]:
    """Blocks of NaN for missing rows of a signal."""
    n_time = target.shape[1]
    block = np.full((_rows_per_block(n_time), n_time), np.nan, target.dtype)
    for first in range(0, n_row, len(block)):
        yield block[: n_row - first]


def write_block(target: h5py.Dataset, row: int, block: Block) -> int:
    """Write a block, but for rows at the fill value, from a row on, and return its number of rows."""
    import h5py

    if isinstance(block, Chunk):
        if block.content:
            target.id.write_direct_chunk((row, 0), block.content, block.filter_mask)
        return 1
    rows = block.astype(target.dtype, copy=False)
    if target.id.get_create_plist().fill_value_defined() != h5py.h5d.FILL_VALUE_USER_DEFINED:
        target[row : row + len(rows)] = rows
        return len(rows)
    stands = np.isnan(rows) if np.isnan(target.fillvalue) else rows == target.fillvalue
    for moving in np.flatnonzero(~stands.all(axis=1)):
        target[row + moving] = rows[moving]
    return len(rows)


def _rows_per_block(n_time: int) -> int:
    return max(1, _BLOCK_BYTES // (8 * n_time))


def _laid_out_alike(source: h5py.Dataset, target: h5py.Dataset) -> bool:
    layouts = [
        (data.chunks, data.dtype, data.compression, data.compression_opts) for data in (source, target)
    ]
    same_fill = np.array_equal(source.fillvalue, target.fillvalue, equal_nan=True)
    return target.chunks is not None and layouts[0] == layouts[1] and same_fill


def _read_chunk(source: h5py.Dataset, row: int) -> Chunk:
    """A row as stored in the file; empty if it is constant at the fill value."""
    if source.id.get_chunk_info_by_coord((row, 0)).byte_offset is None:
        return Chunk(0, b"")
    return Chunk(*source.id.read_direct_chunk((row, 0)))


def _drop_from_page_cache(source: h5py.Dataset, row: int, n_row: int) -> None:
    offset = source.id.get_offset()
    if offset is not None and hasattr(os, "posix_fadvise"):
        size = source.dtype.itemsize * source.shape[1]
        handle = source.file.id.get_vfd_handle()
        os.posix_fadvise(handle, offset + row * size, n_row * size, os.POSIX_FADV_DONTNEED)


@dataclass(frozen=True)
class FileSignals:
    """Signals in an experiment file."""

    path: Path

    def time(self) -> NDArray[np.float64] | None:
        """Sampling instants [s]; None if no signals are stored."""
        with open_for_reading(self.path) as file:
            return np.asarray(file[TIME][:]) if TIME in file else None

    def rows(self, names: Sequence[str], positions: Sequence[int]) -> dict[str, NDArray[np.float64]]:
        """Signals of some runs by name; signals that the file lacks are omitted."""
        with open_for_reading(self.path) as file:
            return {name: _signal_rows(file[name], positions) for name in names if name in file}


def _signal_rows(signal: h5py.Dataset, rows: Sequence[int]) -> NDArray[np.float64]:
    """Rows of a signal in double precision, (n_row, n_time); a shared signal is repeated."""
    if signal.ndim == 1:
        return np.tile(np.asarray(signal[:], dtype=float), (len(rows), 1))
    first = min(rows)
    block: NDArray[np.float64] = np.asarray(signal[first : max(rows) + 1], dtype=float)
    return block if len(block) == len(rows) == 1 else np.take(block, np.asarray(rows) - first, axis=0)
