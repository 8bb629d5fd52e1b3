"""HDF5 and MAT files, read in a process of their own: their libraries may crash or hang on damaged bytes."""

from __future__ import annotations

import atexit
import io
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

import numpy as np

from hydrofdi.records import array_reader
from hydrofdi.records.measured.formats.arrays import ArrayTable, Content
from hydrofdi.records.measured.rejection import RejectionError, damage_named

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
    reader = _free_reader()
    try:
        with damage_named(kind):
            shapes = reader.open(kind, content)
        yield ArrayTable(place, kind, shapes, reader.array, reader.unit)
    finally:
        reader.close()


class _Reader:
    """A process that reads one file at a time; it ends with its parent, or if a request takes too long."""

    def __init__(self) -> None:
        command = [sys.executable, "-P", array_reader.__file__]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)
        self._requests = cast(io.BufferedWriter, self._process.stdin)
        self._answers = cast(io.BufferedReader, self._process.stdout)
        self._kind, self._seconds = "", SECONDS

    def open(self, kind: str, content: Content) -> dict[str, tuple[int, ...]]:
        """Name → shape of each array in a file."""
        data = b"" if isinstance(content, Path) else content.getbuffer()
        path = str(content.absolute()) if isinstance(content, Path) else None
        size = content.stat().st_size if isinstance(content, Path) else len(data)
        self._kind, self._seconds = kind, SECONDS + size / _BYTES_PER_SECOND
        shapes = self.ask("open", data, kind=kind, path=path, size=size)["shapes"]
        return {name: tuple(shape) for name, shape in shapes.items()}

    def array(self, name: str) -> Any:
        """Values of an array; other types than numbers and text are converted to text."""
        return self.ask("array", name=name)["values"]

    def unit(self, name: str) -> str:
        """Unit that the file states."""
        return str(self.ask("unit", name=name)["unit"])

    @property
    def runs(self) -> bool:
        """Whether the process is running."""
        return self._process.poll() is None

    def close(self) -> None:
        """Release the file; the process waits for the next one, unless it is broken."""
        try:
            self.ask("close")
        except (RejectionError, OSError):
            self.end()
        else:
            _idle.append(self)

    def ask(self, do: str, data: bytes | memoryview = b"", **of: Any) -> dict[str, Any]:
        """The answer to a request.

        Raises
        ------
        OSError
            The library cannot read it; the message says why.
        RejectionError
            The process has ended.
        """
        start = time.monotonic()
        try:
            if not self.runs:
                raise EOFError
            request = json.dumps({"do": do, "of": of, "seconds": self._seconds})
            self._requests.write(request.encode() + b"\n")
            self._requests.write(data)
            self._requests.flush()
            answer = self._answer()
        except (EOFError, BrokenPipeError):
            self.end()
            late = time.monotonic() - start >= self._seconds
            what = f"took longer than {self._seconds:.3g} s" if late else "crashed"
            raise RejectionError("damaged", f"reading it as {self._kind} {what}") from None
        except BaseException:
            self.end()
            raise
        if "error" in answer:
            raise OSError(answer["error"])
        return answer

    def _answer(self) -> dict[str, Any]:
        line = self._answers.readline()
        if not line.endswith(b"\n"):
            raise EOFError
        answer: dict[str, Any] = json.loads(line)
        if "texts" in answer:
            answer["values"] = np.array(answer["texts"], dtype=object).reshape(answer["shape"])
        elif "dtype" in answer:
            answer["values"] = values = np.empty(answer["shape"], dtype=answer["dtype"])
            body: Any = values.reshape(-1).view(np.uint8) if values.nbytes else bytearray()
            if self._answers.readinto(body) < values.nbytes:
                raise EOFError
        return answer

    def end(self) -> None:
        """End the process; a second call does nothing."""
        self._process.kill()
        self._process.wait()
        with suppress(OSError):
            self._requests.close()
        self._answers.close()


_idle: list[_Reader] = []
"""Processes that wait for the next file; each open table has its own."""


def _free_reader() -> _Reader:
    while _idle:
        reader = _idle.pop()
        if reader.runs:
            return reader
        reader.end()
    return _Reader()


def _end_all() -> None:
    while _idle:
        _idle.pop().end()


atexit.register(_end_all)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)
