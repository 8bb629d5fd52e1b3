"""Files by their kind: opened for reading, and written for other programs.

HDF5, MAT, MDF and TDMS files are read in a process of their own: their libraries may crash or hang on damaged
bytes.
"""

from __future__ import annotations

import gzip
import math
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, NamedTuple, cast

import numpy as np

from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Array, Channel, RecordBatch, array_reader
from hydrofdi.records.columns import (
    MOST_BYTES,
    FileColumns,
    RejectionError,
    channel_called,
    damage_named,
    scaled,
    split_title,
)
from hydrofdi.records.description import FormatConfig
from hydrofdi.records.text import LongTable, TextTable, blocks_of
from hydrofdi.records.times import are_times, instants_of
from hydrofdi.settings.messages import counted, nearest
from hydrofdi.units import parse_unit, zero_of

_EXACT = 2**53
"""Integers up to here are exact as floats."""
_ROUNDING = 1e-3
"""Share of a step to which larger integers of a clock may be rounded."""
_MOST_COLUMNS = 1000
SECONDS = 60.0
"""Time limit of a request [s], plus one second for each megabyte of the file."""
_BYTES_PER_SECOND = 1e6
Content = Path | BytesIO


class ArrayTable(FileColumns):
    """Columns in arrays: vectors by their name, columns of matrices as ``name[1]``, ``name[2]``, …

    The longer axis of a matrix is time. `load` gives the array of a name; `what` is the kind of file. Times
    of columns count from `since` 1970 [s], if it is stated.
    """

    def __init__(
        self,
        place: str,
        what: str,
        shapes: Mapping[str, tuple[int, ...]],
        load: Callable[[str], Any],
        units: Mapping[str, str] = MappingProxyType({}),
        clocks: Mapping[str, str] = MappingProxyType({}),
        since: float = math.nan,
    ) -> None:
        self.place, self._what, self._load, self._units, self._clocks = place, what, load, units, clocks
        self._since = since
        self._columns = [column for name, shape in shapes.items() for column in _columns(name, shape)]
        self._last: tuple[str, Any] = "", None
        self.titles = [name if number is None else f"{name}[{number + 1}]" for name, number in self._columns]

    def unit(self, position: int) -> str:
        """Unit that the file states."""
        name = self._columns[position][0]
        return self._units.get(name) or split_title(name)[1]

    def clocks(self, time: int | None = None) -> dict[int, int]:
        """Position of a column → that of its own time; the fastest one first."""
        places = {title: position for position, title in enumerate(self.titles)}
        own = ((places.get(name), places[time]) for name, time in self._clocks.items())
        return {position: clock for position, clock in own if position is not None}

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,)."""
        values, where = self._vector(position), f"{self.place}: {self.titles[position]}"
        if values.dtype.kind in "iu" and values.size and max(-int(values.min()), int(values.max())) > _EXACT:
            # a clock may be rounded: its steps are all that counts
            rounded = values.astype(np.float64)
            least = np.diff(rounded).min(initial=np.inf)
            if values.size < 2 or np.spacing(np.abs(rounded).max()) > _ROUNDING * least:
                raise DataError(f"{where}: contains integers beyond 2^53, which are not exact")
        if values.dtype.kind not in "biuf":
            raise DataError(f"{where}: contains {values.dtype.name}, not numbers")
        return np.asarray(values, dtype=np.float64)

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return are_times(self._vector(position))

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, and the first date."""
        if not self.is_dated(position):
            is_clock = self.titles[position] in self._clocks.values()
            return self.numbers(position), self._since if is_clock else math.nan
        try:
            return instants_of(self._vector(position))
        except ValueError as error:
            raise DataError(f"{self.place}: {self.titles[position]}: {error}") from None

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


def content_of(path: Path) -> Content:
    """Input of a library: the path itself, or the decompressed bytes if its name ends in ``.gz``."""
    if path.suffix.lower() != ".gz":
        return path
    with damage_named("gzip"), gzip.open(path, "rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DataError(f"{path}: is larger than {MOST_BYTES / 2**30:g} GiB")
    if not data:
        raise RejectionError("empty", "is empty")
    return BytesIO(data)


_idle: list[subprocess.Popen[bytes]] = []
"""Processes that wait for the next file; each open table has its own."""
os.register_at_fork(after_in_child=_idle.clear)


@contextmanager
def table_read_apart(place: str, kind: str, content: Content) -> Iterator[ArrayTable]:
    """The arrays of an HDF5, MAT, MDF or TDMS file; another process reads each on demand."""
    process = _idle.pop() if _idle else None
    if process is None or process.poll() is not None:  # it was killed while it waited
        command, pipe = [sys.executable, "-P", array_reader.__file__], subprocess.PIPE
        process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
    seconds = SECONDS
    requests, answers = cast(IO[bytes], process.stdin), cast(IO[bytes], process.stdout)

    def ask(*request: Any) -> Any:
        """The answer to a request; a process that gives none is ended."""
        try:
            pickle.dump((seconds, *request), requests)
            requests.flush()
            answer = pickle.load(answers)
        except BaseException as error:
            process.kill()
            process.communicate()
            if not isinstance(error, Exception):
                raise
            answer = OSError(f"it crashed its library, or took longer than {seconds:.3g} s")
        if isinstance(answer, OSError):
            raise answer
        return answer

    try:
        with damage_named(kind):
            given = str(content.absolute()) if isinstance(content, Path) else content.getvalue()
            size = content.stat().st_size if isinstance(content, Path) else len(given)
            seconds += size / _BYTES_PER_SECOND
            shapes, *stated = ask(kind, given)
        yield ArrayTable(place, kind, shapes, ask, *stated)
    finally:
        with suppress(OSError):
            ask()
            _idle.append(process)


def npz_table(place: str, content: Content) -> ArrayTable:
    """The arrays of an archive."""
    with damage_named("NPZ"):
        archive: Any = np.load(content, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise OSError("it is not an archive of arrays")
        with archive:
            if sum(entry.file_size for entry in cast(Any, archive.zip).infolist()) > MOST_BYTES:
                raise OSError(f"it unpacks to more than {MOST_BYTES / 2**30:g} GiB")
            arrays = {name: np.asarray(archive[name]) for name in archive.files}
    shapes = {name: array.shape for name, array in arrays.items()}
    return ArrayTable(place, "NPZ", shapes, arrays.__getitem__)


def parquet_library() -> Any:
    """The module ``pyarrow.parquet``."""
    try:
        import pyarrow.parquet as parquet
    except ImportError:
        raise DataError("Parquet needs the extra 'parquet': pip install 'hydrofdi[parquet]'") from None
    return parquet


def parquet_table(place: str, content: Content) -> ArrayTable:
    """The columns of a file."""
    parquet = parquet_library()
    with damage_named("Parquet"):
        file = parquet.ParquetFile(content)
        n_row, names = file.metadata.num_rows, file.schema_arrow.names

    def load(name: str) -> Any:
        return file.read(columns=[name]).column(0).to_numpy()

    return ArrayTable(place, "Parquet", dict.fromkeys(names, (n_row,)), load)


_KINDS = {
    **dict.fromkeys((".csv", ".tsv", ".tab", ".txt", ".dat", ".asc", ".lvm"), "text"),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".nc"), "hdf5"),
    ".mat": "mat",
    **dict.fromkeys((".mf4", ".mdf"), "mdf"),
    ".tdms": "tdms",
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    ".npz": "npz",
}
"""Suffix → kind."""
_LIBRARIES = {"mdf": "asammdf", "tdms": "nptdms"}
"""Kind → library of the extra ``measurement``."""


@contextmanager
def open_table(path: Path, place: str, form: FormatConfig) -> Iterator[FileColumns]:
    """The columns of a file, to be read while it is open."""
    suffix = (Path(path.stem) if path.suffix.lower() == ".gz" else path).suffix
    if (kind := form.kind or _KINDS.get(suffix.lower())) is None:
        hint = nearest(suffix, list(_KINDS)) if suffix else ""
        raise DataError(
            f"{place}: unknown suffix {suffix!r}{hint}; hydrofdi reads {', '.join(_KINDS)} (or write"
            " 'format: {kind: text}' in the YAML that describes the file, docs/measured.md)"
        )
    if kind == "text":
        text = TextTable(place, form, partial(blocks_of, path, place, form.encoding))
        yield text if form.long is None else LongTable(text, form.long)
        return
    if kind in _LIBRARIES and find_spec(_LIBRARIES[kind]) is None:
        extra = "pip install 'hydrofdi[measurement]'"
        raise DataError(f"{place}: {kind.upper()} needs the extra 'measurement': {extra}")
    content = content_of(path)
    if kind in ("parquet", "npz"):
        yield (parquet_table if kind == "parquet" else npz_table)(place, content)
        return
    with table_read_apart(place, kind.upper(), content) as table:
        yield table


class WrittenColumn(NamedTuple):
    """Samples under the symbol of a channel, or ``time``, with their unit."""

    name: str
    unit: str
    values: Array


def titled(name: str, unit: str) -> str:
    """The header with a unit, as readers of measured files and of streams expect it."""
    return f"{name} [{unit}]"


@dataclass(frozen=True)
class Selection:
    """Which channels are written, in this order, all if empty; and in which units, SI if not stated."""

    channels: Sequence[Channel]
    units: Mapping[Channel, str]

    def columns(self, batch: RecordBatch, row: int) -> Iterator[WrittenColumn]:
        """Time and the channels of a record."""
        yield WrittenColumn("time", "s", batch.time)
        for channel in self.channels or batch.channels:
            if channel not in batch.channels:
                has = ", ".join(each.symbol for each in batch.channels)
                raise DataError(f"{batch.sources[row]}: has no {channel.symbol} ({channel}); it has {has}")
            own, values = batch.unit(channel), batch[channel][row]
            if channel in batch.relative:
                yield WrittenColumn(channel.symbol, "-" if own == "1" else own, values)
                continue
            unit = self.units.get(channel, own)
            factor = parse_unit(own).factor / parse_unit(unit).factor
            zero = zero_of(unit)
            yield WrittenColumn(channel.symbol, unit, scaled(values - zero if zero else values, factor))


def selection(channels: Collection[str], units: Collection[str]) -> Selection:
    """A selection from symbols or names of channels, and units, each for the channels of its dimension."""
    chosen, of = tuple(dict.fromkeys(map(channel_called, channels))), dict[Channel, str]()
    for unit in units:
        try:
            exponents = parse_unit(unit).exponents
        except ValueError as error:
            raise ConfigError(f"unit: {error}") from None
        fitting = [each for each in chosen or Channel if parse_unit(each.unit).exponents == exponents]
        if not fitting:
            symbols = ", ".join(channel.symbol for channel in chosen or Channel)
            raise ConfigError(f"unit {unit!r} fits none of the channels {symbols}")
        if fitting[0] in of:
            raise ConfigError(
                f"units {of[fitting[0]]} and {unit} both fit {fitting[0].symbol}; give one of them"
            )
        of |= dict.fromkeys(fitting, unit)
    return Selection(chosen, of)


_ROWS_AT_ONCE = 100_000


def write_csv(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Rows under a header such as ``time [s],P1 [Pa]``; a missing number is an empty field."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(",".join(titled(name, unit) for name, unit, _ in columns) + "\n")
        for first in range(0, columns[0].values.size, _ROWS_AT_ONCE):
            parts = (column.values[first : first + _ROWS_AT_ONCE].tolist() for column in columns)
            file.writelines(",".join(map(_text, row)) + "\n" for row in zip(*parts, strict=True))


def write_parquet(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Columns named as in CSV; their units are also metadata ``units`` of the fields."""
    parquet = parquet_library()
    import pyarrow

    fields = [
        pyarrow.field(titled(name, unit), pyarrow.float64(), metadata={"units": unit})
        for name, unit, _ in columns
    ]
    arrays = [pyarrow.array(values) for _, _, values in columns]
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)


def write_mat(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Column vectors ``time``, ``P1``, … and a structure ``units`` with the unit of each; MAT version 5."""
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    content: dict[str, Any] = {column.name: np.ascontiguousarray(column.values) for column in columns}
    units = {column.name: column.unit for column in columns}
    try:
        savemat(str(path), content | {"units": units}, appendmat=False, oned_as="column", do_compression=True)
    except MatWriteError:
        raise DataError(
            f"{counted(columns[0].values.size, 'sample')} are too many for MAT; write Parquet"
        ) from None


WRITERS = {"csv": write_csv, "parquet": write_parquet, "mat": write_mat}
"""Form, which is also the suffix → its writer."""

OWN = {
    "csv": re.compile(rb"time \[s\],"),
    "parquet": re.compile(rb"PAR1"),
    "mat": re.compile(rb"MATLAB 5\.0 MAT-file"),
}
"""Form → first bytes of its files."""


def _text(value: float) -> str:
    return "" if value != value else repr(value)
