"""Files that are either whole or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from hydrofdi.errors import StoreError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path beside `path` to write to; it takes the place of `path` once the block ends without an error.

    Raises
    ------
    StoreError
        The folder cannot be made or written.
    """
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield aside
        with open(aside, "rb") as file:
            os.fsync(file.fileno())
        os.replace(aside, path)
    except OSError as error:
        if isinstance(error, StoreError):
            raise
        raise StoreError(f"{path}: cannot be written: {reason(error)}") from None
    finally:
        aside.unlink(missing_ok=True) if os.access(aside.parent, os.W_OK) else None


@contextmanager
def open_for_reading(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file.

    Raises
    ------
    StoreError
        It is missing or damaged.
    """
    try:
        file = h5py.File(path, "r")
    except FileNotFoundError:
        raise StoreError(f"{path}: no such file") from None
    except OSError as error:
        raise StoreError(f"{path}: is not a readable HDF5 file: {reason(error)}") from None
    with file:
        try:
            yield file
        except (KeyError, RuntimeError, OSError) as error:
            if isinstance(error, StoreError):
                raise
            raise StoreError(f"{path}: is damaged: {reason(error)}") from error


def reason(error: Exception) -> str:
    """The cause of an error in a few words."""
    return getattr(error, "strerror", None) or str(error).strip("'\"").splitlines()[0]
