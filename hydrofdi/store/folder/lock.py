"""Lock of an experiment's folder against concurrent sweeps, and locks of other files."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from io import FileIO
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.store.files import open_own, reason, write_all

_FILE = ".lock"
_OWN = b'{"pid": '


@contextmanager
def experiment_lock(directory: Path, tell: Callable[[str], None], part: str = "") -> Iterator[None]:
    """Lock the folder of an experiment, or one part of its sweep, which shares the folder with others."""
    own = directory / (f".part{part}.lock" if part else _FILE)
    with _shared(directory) if part else nullcontext(), file_lock(own, _busy(directory)) as holder:
        if holder:
            tell(f"took over a stale lock of a sweep that was killed{holder}")
        yield


@contextmanager
def _shared(directory: Path) -> Iterator[None]:
    """Keep whole sweeps away from a folder, but no parts."""
    with open_own(directory / _FILE, _OWN, "a lock") as file:
        take_lock(file, _busy(directory), fcntl.LOCK_SH)
        file.truncate(0)
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


def take_lock(file: FileIO, refusal: str, kind: int = fcntl.LOCK_EX) -> None:
    """Lock an open file until it is closed."""
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except OSError as error:
        is_held = isinstance(error, BlockingIOError)
        raise StoreError(refusal + (_holder(_text(file)) if is_held else f": {reason(error)}")) from None


def require_unlocked(directory: Path, *, shared: bool) -> None:
    """Check, without creating files, that no sweep has locked the folder; none but parts if it is shared."""
    try:
        file = open(directory / _FILE, "r+", encoding="utf-8")  # noqa: SIM115 (closed below)
    except OSError:
        return
    with file:
        try:
            fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
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
