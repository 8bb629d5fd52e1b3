"""Atomic writing and checked reading of files."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from secrets import token_hex
from stat import S_ISREG
from typing import TYPE_CHECKING

from hydrofdi.errors import StoreError
from hydrofdi.records.array_reader import open_hdf5

if TYPE_CHECKING:
    import h5py

LIBRARY_VERSIONS = ("v110", "v110")
"""HDF5 format versions of written files: from 1.10 on, all metadata have checksums, so a damaged file is
reported instead of causing an endless loop."""

_EDGE_BYTES = 1 << 20


@contextmanager
def whole_file(path: Path, final: Callable[[], Path] | None = None) -> Iterator[Path]:
    """Yield a temporary path; it becomes `path` (or `final`) when the block ends without an error."""
    if path.is_dir():
        raise StoreError(f"{path}: cannot be written: is a directory")
    aside = path.with_name(f".{path.name}.{token_hex(8)}.part")  # others write here, too, from other machines
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield aside
        with open(aside, "rb") as file:
            os.fsync(file.fileno())
        os.replace(aside, final() if final else path)
        folder = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(folder)  # so that its entries survive a crash of the machine
        finally:
            os.close(folder)
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:
        raise StoreError(f"{path}: cannot be written: {reason(error)}") from None
    finally:
        if aside.exists():
            aside.unlink()


def require_regular(path: Path) -> None:
    """Check, without opening it, that a path or its link target is a regular file if it exists."""
    if path.exists() and not path.is_file():
        raise StoreError(f"{path}: is not a regular file and was not changed")


def require_replaceable(path: Path) -> None:
    """Check that writing an experiment file to a path overwrites nothing but an experiment file."""
    import h5py

    if path.suffix != ".h5":
        raise StoreError(
            f"{path}: results are written to a file whose name ends in .h5; 'hydrofdi export' writes .csv,"
            " .parquet and .mat"
        )
    if not path.is_file() or not path.stat().st_size:
        return
    if not h5py.is_hdf5(path) or not is_experiment_file(path):
        raise StoreError(
            f"{path}: already exists, is not an experiment file of hydrofdi and was not changed; choose"
            " another name"
        )


def require_own(path: Path, own: re.Pattern[bytes], what: str) -> None:
    """Check that a file that is to be replaced is empty, or begins (Parquet: ends) as hydrofdi writes it."""
    require_regular(path)
    if path.exists() and path.stat().st_size and not own.match(_edges(path)):
        raise StoreError(f"{path}: already exists, is not {what} and was not changed; choose another name")


def open_own(path: Path, own: bytes, what: str) -> FileIO:
    """Open a file to read it and to add to it; a new or empty one, or an earlier one of the same kind."""
    flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = FileIO(os.open(path, flags, 0o666), "a+")
    except OSError as error:
        text = "is a link" if error.errno == errno.ELOOP else reason(error)
        raise StoreError(f"{path}: cannot be written: {text}") from None
    is_regular = S_ISREG(os.fstat(file.fileno()).st_mode)
    if not is_regular or not own.startswith(os.pread(file.fileno(), len(own), 0)):
        file.close()
        kind = what if is_regular else "a regular file"
        raise StoreError(f"{path}: is not {kind} and was not changed; choose another name")
    return file


def write_all(file: FileIO, data: bytes) -> None:
    """Write all bytes; on a full disk the last ones, not the first, are refused."""
    while data:
        data = data[file.write(data) :]


def _edges(path: Path) -> bytes:
    """The first and the last bytes of a file; Parquet names its columns at the end."""
    with path.open("rb") as file:
        head = file.read(_EDGE_BYTES)
        file.seek(max(file.tell(), path.stat().st_size - _EDGE_BYTES))
        return head + file.read()


def write_whole_text(path: Path, text: str) -> None:
    """Write a text file atomically."""
    with whole_file(path) as aside:
        aside.write_text(text, encoding="utf-8")


def remove_leftovers(directory: Path) -> None:
    """Remove incomplete files of killed processes, and locks of parts, from a locked experiment's folder."""
    for path in (*directory.rglob(".*.part"), *directory.glob(".part-*.lock")):
        path.unlink(missing_ok=True)


@contextmanager
def open_for_reading(path: Path) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading."""
    try:
        file = open_hdf5(path)
    except FileNotFoundError:
        raise StoreError(f"{path}: no such file") from None
    except OSError as error:
        raise StoreError(f"{path}: is not a readable HDF5 file: {reason(error)}") from None
    with file:
        try:
            yield file
        except StoreError:
            raise
        except (KeyError, RuntimeError, OSError, TypeError, ValueError) as error:
            raise StoreError(f"{path}: is damaged: {reason(error)}") from error


def is_experiment_file(path: Path) -> bool:
    """Whether an HDF5 file is an experiment file of hydrofdi, of any version."""
    with open_for_reading(path) as file:
        return "format_version" in file.attrs and "configuration" in file.attrs


_ERRNO = re.compile(r"\berrno(?: =)? (\d+)\b", re.IGNORECASE)
"""The system's error number within the text of a library: ``errno = 28`` of HDF5, ``[errno 28]`` of Arrow."""


def reason(error: Exception) -> str:
    """The cause of an error in a few words: the system's, if there is one."""
    text = getattr(error, "strerror", None) or str(error).strip("'\"") or type(error).__name__
    if isinstance(error, FileExistsError) and error.filename:
        return f"{error.filename} is not a folder"
    if number := _ERRNO.search(text):
        return os.strerror(int(number[1]))
    return str(text).splitlines()[0]
