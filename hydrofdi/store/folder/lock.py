"""Lock of an experiment's folder against concurrent sweeps, and locks of other files."""

from __future__ import annotations

import fcntl
import json
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from hydrofdi.errors import StoreError
from hydrofdi.store.files import reason

_FILE = ".lock"


@contextmanager
def experiment_lock(directory: Path, tell: Callable[[str], None]) -> Iterator[None]:
    """Lock the folder of an experiment; the operating system releases the lock when this process ends.

    Parameters
    ----------
    directory : Path
    tell : callable
        Called with a message when a stale lock of a dead process is taken over.

    Raises
    ------
    StoreError
        Another sweep holds the lock; the message names its process and host.
    """
    path = directory / _FILE
    with file_lock(path, directory, _busy(directory)) as holder:
        if holder:
            tell(f"took over a stale lock of a sweep that was killed{holder}")
        yield


@contextmanager
def file_lock(path: Path, guarded: Path, refusal: str) -> Iterator[str]:
    """Lock a file; the operating system releases the lock when this process ends.

    Parameters
    ----------
    path : Path
    guarded : Path
        What the lock is for; messages name it.
    refusal : str
        Message if another process holds the lock.

    Yields
    ------
    str
        Process that left a stale lock; empty if there was none.

    Raises
    ------
    StoreError
        Another process holds the lock, or the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = open(path, "a+", encoding="utf-8")  # noqa: SIM115 (stays open while locked)
    except OSError as error:
        raise StoreError(f"{guarded}: cannot be written: {reason(error)}") from None
    with file:
        file.seek(0)
        text = file.read()
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            raise StoreError(refusal + _holder(file.read())) from None
        file.truncate(0)
        file.write(json.dumps({"pid": os.getpid(), "host": socket.gethostname()}))
        file.flush()
        try:
            yield _holder(text)
        finally:
            file.truncate(0)


def require_unlocked(directory: Path) -> None:
    """Check, without creating files, that no sweep has locked the folder of an experiment.

    Raises
    ------
    StoreError
        A sweep has locked it; the message names its process and host.
    """
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


def _holder(text: str) -> str:
    try:
        entry = json.loads(text)
        return f" (process {entry['pid']} on {entry['host']})"
    except (ValueError, KeyError, TypeError):
        return ""
