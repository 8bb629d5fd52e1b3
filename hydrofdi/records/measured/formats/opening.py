"""Opening a measured file by its kind.

HDF5 and MAT files are read in a process of their own: their libraries may crash or hang on damaged bytes.
"""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, cast

from hydrofdi.errors import DataError
from hydrofdi.records import array_reader
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.arrays import ArrayTable, Content, content_of, npz_table
from hydrofdi.records.measured.formats.table import RejectionError, Table, damage_named
from hydrofdi.records.measured.formats.text import TextTable
from hydrofdi.settings.messages import nearest

SECONDS = 60.0
"""Time limit of a request [s], plus one second for each megabyte of the file."""
_BYTES_PER_SECOND = 1e6


@contextmanager
def table_read_apart(place: str, kind: str, content: Content) -> Iterator[ArrayTable]:
    """The arrays of an HDF5 or MAT file; each is read on demand.

    Raises
    ------
    RejectionError
        The file cannot be read, or reading it crashes or takes too long.
    """
    reader = _idle.pop() if _idle else _Reader()
    if reader.process.poll() is not None:  # it was killed while it waited
        reader.end()
        reader = _Reader()
    reader.kind = kind
    try:
        with damage_named(kind):
            given = str(content.absolute()) if isinstance(content, Path) else content.getvalue()
            size = content.stat().st_size if isinstance(content, Path) else len(given)
            reader.seconds = SECONDS + size / _BYTES_PER_SECOND
            shapes, units = reader.ask("open", given)
        yield ArrayTable(place, kind, shapes, lambda name: reader.ask("array", name), units)
    finally:
        try:
            reader.ask("close")
            _idle.append(reader)
        except (RejectionError, OSError):
            reader.end()


class _Reader:
    """A process that reads one file at a time; it ends with its parent, or if a request takes too long."""

    def __init__(self) -> None:
        command = [sys.executable, "-P", array_reader.__file__]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
        self.kind, self.seconds = "", SECONDS

    def ask(self, action: str, *of: Any) -> Any:
        """The answer to a request.

        Raises
        ------
        OSError
            The library cannot read it; the message says why.
        RejectionError
            The process has ended.
        """
        start, requests = time.monotonic(), cast(IO[bytes], self.process.stdin)
        try:
            pickle.dump((self.seconds, self.kind, action, *of), requests)
            requests.flush()
            answer = pickle.load(cast(IO[bytes], self.process.stdout))
        except (EOFError, OSError, ValueError, pickle.UnpicklingError):
            self.end()
            late = time.monotonic() - start >= self.seconds
            what = f"took longer than {self.seconds:.3g} s" if late else "crashed"
            raise RejectionError("damaged", f"reading it as {self.kind} {what}") from None
        except BaseException:
            self.end()
            raise
        if isinstance(answer, OSError):
            raise answer
        return answer

    def end(self) -> None:
        """End the process; a second call does nothing."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with suppress(OSError):
                cast(IO[bytes], pipe).close()


_idle: list[_Reader] = []
"""Processes that wait for the next file; each open table has its own."""


@atexit.register
def _end_all() -> None:
    while _idle:
        _idle.pop().end()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)


def parquet_table(place: str, content: Content) -> ArrayTable:
    """The columns of a file.

    Raises
    ------
    DataError
        pyarrow is not installed.
    """
    try:
        import pyarrow.parquet as parquet
    except ImportError:
        message = "Parquet needs the extra 'parquet': pip install 'hydrofdi[parquet]'"
        raise DataError(f"{place}: {message}") from None
    with damage_named("Parquet"):
        file = parquet.ParquetFile(content)
        n_row, names = file.metadata.num_rows, file.schema_arrow.names

    def load(name: str) -> Any:
        return _values(file.read(columns=[name]).column(0))

    return ArrayTable(place, "Parquet", dict.fromkeys(names, (n_row,)), load)


def _values(column: Any) -> Any:
    import pyarrow

    if pyarrow.types.is_integer(column.type) and column.null_count:
        column = column.cast(pyarrow.float64())
    return column.to_numpy()


_KINDS = {
    **dict.fromkeys((".csv", ".tsv", ".tab", ".txt", ".dat", ".asc"), "text"),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".nc"), "hdf5"),
    ".mat": "mat",
    **dict.fromkeys((".parquet", ".pq"), "parquet"),
    ".npz": "npz",
}
"""Suffix → kind."""


@contextmanager
def open_table(path: Path, place: str, form: FormatConfig) -> Iterator[Table]:
    """The columns of a file, to be read while it is open.

    Raises
    ------
    DataError
        The kind of file is unknown, or it is not as described.
    RejectionError
        It cannot be read.
    """
    kind = form.kind or kind_of(path, place)
    if kind == "text":
        yield TextTable(path, place, form)
        return
    content = content_of(path)
    match kind:
        case "parquet":
            yield parquet_table(place, content)
        case "npz":
            with npz_table(place, content) as table:
                yield table
        case _:
            with table_read_apart(place, kind.upper(), content) as table:
                yield table


def kind_of(path: Path, place: str) -> str:
    """Kind of a file by its suffix.

    Raises
    ------
    DataError
        The suffix is unknown.
    """
    suffix = Path(path.stem).suffix if path.suffix.lower() == ".gz" else path.suffix
    if suffix.lower() in _KINDS:
        return _KINDS[suffix.lower()]
    hint = nearest(suffix, list(_KINDS)) if suffix else ""
    raise DataError(
        f"{place}: unknown suffix {suffix!r}{hint}; hydrofdi reads {', '.join(_KINDS)} (or write"
        " 'format: {kind: text}' in the YAML that describes the file, docs/measured.md)"
    )
