"""Lock of an experiment's folder against concurrent sweeps, and locks of other files."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.store.files import open_own, reason, write_all

_FILE = ".lock"
_OWN = b'{"pid": '


@contextmanager
def experiment_lock(directory: Path, tell: Callable[[str], None]) -> Iterator[None]:
    """Lock the folder of an experiment; the operating system releases the lock when this process ends."""
    with file_lock(directory / _FILE, _busy(directory)) as holder:
        if holder:
            tell(f"took over a stale lock of a sweep that was killed{holder}")
        yield


@contextmanager
def file_lock(path: Path, refusal: str) -> Iterator[str]:
    """Lock a file; the operating system releases the lock when this process ends."""
    with open_own(path, _OWN, "a lock") as file:
        take_lock(file, refusal)
        holder = _holder(_text(file))
        owner = _OWN + f'{os.getpid()}, "host": {json.dumps(socket.gethostname())}}}'.encode()
        try:
            file.truncate(0)
            write_all(file, owner)
        except OSError as error:
            raise StoreError(f"{path}: cannot be written: {reason(error)}") from None
        try:
            yield holder
        finally:
            file.truncate(0)


def take_lock(file: FileIO, refusal: str) -> None:
    """Lock an open file until it is closed."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        is_held = isinstance(error, BlockingIOError)
        raise StoreError(refusal + (_holder(_text(file)) if is_held else f": {reason(error)}")) from None


def require_unlocked(directory: Path) -> None:
    """Check, without creating files, that no sweep has locked the folder of an experiment."""
    try:
        file = open(directory / _FILE, encoding="utf-8")  # noqa: SIM115 (closed below)
    except OSError:
        return
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StoreError(_busy(directory) + _holder(file.read())) from None


def _busy(directory: Path) -> str:
    return f"{directory}: another sweep is at work there"


def _text(file: FileIO) -> bytes:
    return os.pread(file.fileno(), 1000, 0)


def _holder(text: str | bytes) -> str:
    try:
        entry = json.loads(text)
        return f" (process {entry['pid']} on {entry['host']})"
    except (ValueError, KeyError, TypeError):
        return ""
