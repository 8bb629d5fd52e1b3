"""Bytes of a measured file, decompressed if it is compressed."""

from __future__ import annotations

import gzip
from io import BytesIO
from pathlib import Path

from hydrofdi.errors import DataError
from hydrofdi.records.measured.rejection import RejectionError, damage_named

Content = Path | BytesIO

_MOST_BYTES = 2**31


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
        data = file.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        raise DataError(f"{path}: is larger than {_MOST_BYTES / 2**30:g} GiB")
    if not data:
        raise RejectionError("empty", "is empty")
    return data


def content_of(path: Path) -> Content:
    """Input of a library: the path itself, or the decompressed bytes."""
    return BytesIO(file_bytes(path)) if path.suffix.lower() == ".gz" else path
