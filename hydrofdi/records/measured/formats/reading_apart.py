"""HDF5 and MAT files, read in a process of their own: their libraries may crash or hang on damaged bytes."""

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

from hydrofdi.records import array_reader
from hydrofdi.records.measured.formats.arrays import ArrayTable, Content
from hydrofdi.records.measured.formats.table import RejectionError, damage_named

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
