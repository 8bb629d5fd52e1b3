"""Arrays by name: the content of HDF5, MAT, NPZ and Parquet files."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array
from hydrofdi.records.measured.columns import split_title
from hydrofdi.records.measured.formats.table import RejectionError, Table, damage_named
from hydrofdi.settings.messages import counted

_EXACT = 2**53
"""Integers up to here are exact as floats."""
_MOST_COLUMNS = 1000


class ArrayTable(Table):
    """Columns in arrays: vectors by their name, columns of matrices as ``name[1]``, ``name[2]``, …

    Parameters
    ----------
    place : str
    what : str
        Kind of file, for messages.
    shapes : mapping of str to tuple of int
        Name → shape, known before the arrays are read. The longer axis of a matrix is time.
    load : callable
        Name → array, as the file contains it.
    units : mapping of str to str, optional
        Name → unit that the file states.
    """

    def __init__(
        self,
        place: str,
        what: str,
        shapes: Mapping[str, tuple[int, ...]],
        load: Callable[[str], Any],
        units: Mapping[str, str] | None = None,
    ) -> None:
        self.place, self._what, self._load, self._units = place, what, load, units or {}
        self._columns = [column for name, shape in shapes.items() for column in _columns(name, shape)]
        self._last: tuple[str, Any] = "", None
        self.titles = [name if number is None else f"{name}[{number + 1}]" for name, number in self._columns]

    def unit(self, position: int) -> str:
        """Unit that the file states."""
        name = self._columns[position][0]
        return self._units.get(name) or split_title(name)[1]

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,)."""
        values, where = self._vector(position), f"{self.place}: {self.titles[position]}"
        if values.dtype.kind in "iu" and values.size and _magnitude(values) > _EXACT:
            raise DataError(f"{where}: contains integers beyond 2^53, which are not exact")
        if values.dtype.kind == "c":
            raise DataError(f"{where}: contains complex numbers")
        if values.dtype.kind not in "biuf":
            raise DataError(f"{where}: contains {values.dtype.name}, not numbers")
        return np.asarray(values, dtype=np.float64)

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return bool(self._vector(position).dtype.kind == "M")

    def instants(self, position: int) -> Array:
        """Values of a time column; of dates, the time since the first one [s]."""
        values = self._vector(position)
        if values.dtype.kind != "M":
            return self.numbers(position)
        known = values[~np.isnat(values)]
        return (values - known[:1]) / np.timedelta64(1, "s") if known.size else np.full(values.size, np.nan)

    def text(self, position: int) -> str:
        """The value of a constant column."""
        values = {_as_text(value) for value in self._vector(position).tolist()}
        if len(values) != 1:
            raise DataError(
                f"{self.place}: {self.titles[position]}: contains {counted(len(values), 'different value')}"
            )
        return values.pop()

    def _vector(self, position: int) -> Any:
        name, number = self._columns[position]
        if name != self._last[0]:
            with damage_named(self._what):
                values = np.asarray(self._load(name))
            self._last = name, values.T if values.ndim == 2 and values.shape[1] > values.shape[0] else values
        values = self._last[1]
        return values.reshape(-1) if number is None else values[:, number]


def _columns(name: str, shape: tuple[int, ...]) -> list[tuple[str, int | None]]:
    if sum(length != 1 for length in shape) <= 1:
        return [(name, None)]
    if len(shape) != 2 or shape[0] == shape[1] or 0 in shape or min(shape) > _MOST_COLUMNS:
        return []
    return [(name, number) for number in range(min(shape))]


def _magnitude(values: Any) -> int:
    return max(abs(int(values.max())), abs(int(values.min())))


def _as_text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


Content = Path | BytesIO

MOST_BYTES = 2**31


def file_bytes(path: Path) -> bytes:
    """All bytes of a file, decompressed if its name ends in ``.gz``.

    Raises
    ------
    DataError
        It is larger than 2 GiB.
    RejectionError
        It cannot be read or decompressed.
    """
    opener = gzip.open if path.suffix.lower() == ".gz" else open
    with damage_named("gzip" if path.suffix.lower() == ".gz" else "a file"), opener(path, "rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DataError(f"{path}: is larger than {MOST_BYTES / 2**30:g} GiB")
    if not data:
        raise RejectionError("empty", "is empty")
    return data


def content_of(path: Path) -> Content:
    """Input of a library: the path itself, or the decompressed bytes."""
    return BytesIO(file_bytes(path)) if path.suffix.lower() == ".gz" else path


@contextmanager
def npz_table(place: str, content: Content) -> Iterator[ArrayTable]:
    """The arrays of an archive."""
    with damage_named("NPZ"):
        archive: Any = np.load(content, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise RejectionError("damaged", "cannot be read as NPZ: it is not an archive of arrays")
    with archive:
        with damage_named("NPZ"):
            arrays = {name: np.asarray(archive[name]) for name in archive.files}
        shapes = {name: array.shape for name, array in arrays.items()}
        yield ArrayTable(place, "NPZ", shapes, arrays.__getitem__)
