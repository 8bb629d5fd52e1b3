"""What a monitor stores: its state, an SQLite database with a row for each machine, and its log."""

from __future__ import annotations

import io
import json
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from zlib import crc32

import numpy as np

from hydrofdi.errors import StoreError
from hydrofdi.monitor.growing_file import found_again, place_in
from hydrofdi.monitor.sources import Position
from hydrofdi.records.streams import State
from hydrofdi.store.files import open_own, reason, require_regular, write_all
from hydrofdi.store.folder import file_lock, take_lock

VERSION = 7
"""Raise it when arrays of the state get another name or meaning."""

WHOLE = "1/1"
"""Partition of a process that has all machines."""

_MARK = 0x48464644
"""Mark of the database: the letters HFFD."""

_MARKS = "application_id", "user_version"

_TABLES = """
create table machine (
    name text primary key, source text, detector text, position text, state blob, checksum integer
) without rowid;
create table log (position text);
create table fleet (partition text);
"""


@dataclass(frozen=True)
class StoredMachine:
    """The state of a machine after a step, of which source and detector it is, and where the source
    continues."""

    source: str
    detector: str
    position: Position
    state: State


class StateStore:
    """The database. After a crash of process or machine it has the rows of the last transaction."""

    _database: sqlite3.Connection

    def __init__(self, path: Path, partition: str = WHOLE) -> None:
        self.path, self._partition = path.resolve(), partition

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Lock the database for this process, and open it."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        require_regular(self.path)
        lock = self.path.with_name(f".{self.path.name}.lock")
        with file_lock(lock, f"{self.path}: another monitor uses it"):
            with self._troubles("opened"):
                self._database = sqlite3.connect(self.path, isolation_level=None)
            try:
                self._prepare(self._database)
                yield
            finally:
                self._database.close()

    def read(self, name: str) -> StoredMachine | None:
        """What is stored of a machine; None if nothing is."""
        question = "select source, detector, position, state from machine where name = ?"
        with self._troubles("read"):
            row = self._database.execute(question, (name,)).fetchone()
        if row is None:
            return None
        source, detector, position, body = row
        try:
            return StoredMachine(source, detector, dict(json.loads(position)), _unpacked(body))
        except (ValueError, TypeError):  # a forged row has the right checksum
            raise self._damage from None

    def read_log(self) -> Position:
        """Where the log continues; empty at the first start."""
        with self._troubles("read"):
            row = self._database.execute("select position from log").fetchone()
        return {} if row is None else dict(json.loads(row[0]))

    def write(self, machines: Mapping[str, StoredMachine], log: Position) -> None:
        """Store machines and the position of the log: all or nothing, and through a crash of the machine."""
        with self._troubles("written"), self._database as database:
            database.execute("begin immediate")
            insert = "insert or replace into machine values (?, ?, ?, ?, ?, ?)"
            for name, machine in machines.items():  # one after the other, as many together need memory
                body, position = _packed(machine.state), json.dumps(dict(machine.position))
                row = name, machine.source, machine.detector, position, body
                database.execute(insert, (*row, _checksum(*row)))
            database.execute("delete from log")
            database.execute("insert into log values (?)", (json.dumps(dict(log)),))

    def _prepare(self, database: sqlite3.Connection) -> None:
        """Make a new database, or check that this one has the same owner."""
        marks, is_new = list[int](), False
        with suppress(sqlite3.DatabaseError):  # another kind of file
            marks = [database.execute(f"pragma {key}").fetchone()[0] for key in _MARKS]
            is_new = not database.execute("select count(*) from sqlite_master").fetchone()[0]
        if not is_new and marks != [_MARK, VERSION]:
            what = "belongs to another version, or is not the state of a monitor"
            raise StoreError(f"{self.path}: {what}, and was not changed; choose another name")
        with self._troubles("read"):
            database.execute("pragma journal_mode = wal")
            database.execute("pragma synchronous = full")
            if is_new:
                database.executescript(
                    f"begin; pragma application_id = {_MARK}; pragma user_version = {VERSION};"
                    f"{_TABLES} insert into fleet values ('{self._partition}'); commit;"
                )
            (partition,) = database.execute("select partition from fleet").fetchone()
            if partition != self._partition:
                raise StoreError(
                    f"{self.path}: is that of partition {partition}, not of {self._partition}; start all"
                    " partitions with new states, once those before have caught up"
                )
            for *row, checksum in database.execute("select * from machine"):
                if not isinstance(row[-1], bytes) or checksum != _checksum(*row):
                    raise self._damage

    @property
    def _damage(self) -> StoreError:
        return StoreError(f"{self.path}: is damaged; remove it to start from scratch")

    @contextmanager
    def _troubles(self, what: str) -> Iterator[None]:
        try:
            yield
        except sqlite3.DatabaseError as error:
            raise StoreError(f"{self.path}: cannot be {what}: {reason(error)}") from None


def _checksum(name: str, source: str, detector: str, position: str, state: bytes) -> int:
    """Of a row without its checksum."""
    return crc32(state, crc32(repr((name, source, detector, position)).encode()))


def _packed(state: State) -> bytes:
    """Arrays as a line of JSON with their names, kinds and shapes, and their bytes."""
    head = [(name, array.dtype.str, array.shape) for name, array in state.items()]
    return b"\n".join([json.dumps(head).encode(), b"".join(array.tobytes() for array in state.values())])


def _unpacked(body: bytes) -> dict[str, np.ndarray]:
    head, _, data = body.partition(b"\n")
    state, first = {}, 0
    for name, kind, shape in json.loads(head):
        dtype = np.dtype(kind)
        stop = first + dtype.itemsize * int(np.prod(shape, dtype=int))
        state[name] = np.frombuffer(data[first:stop], dtype).reshape(shape).copy()
        first = stop
    return state


_OWN = b'{"line": "'

LARGEST_BACKLOG = 16 * 2**20
"""Most bytes of lines that wait in memory while the disk is full."""


class WindowLog:
    """JSON lines in a file that no other monitor writes meanwhile.

    The state stores the lines of a step and their place before they are written, so that a restart
    writes those that are not there. If the file is renamed, the next step begins a new one.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._waiting = b""
        self._file: io.FileIO | None = None

    def open(self, position: Position) -> None:
        """Continue at the end of the file, with the lines of a stored position that were not written."""
        file = self._opened()
        try:
            self._waiting = _unwritten(position, file) if position else b""
        except OSError as error:
            raise self._refused(error) from None

    @property
    def position(self) -> Position:
        """Waiting lines, and their place: path and end of the file."""
        file = self._opened()
        position = place_in(file.fileno(), os.fstat(file.fileno()).st_size)
        return {"path": str(self.path.resolve()), "waiting": self._waiting.decode(), **position}

    def take(self, text: str) -> None:
        """Let lines of JSON wait."""
        self._waiting += text.encode()
        if len(self._waiting) > LARGEST_BACKLOG:
            self._waiting = self._waiting[
                self._waiting.index(b"\n", len(self._waiting) - LARGEST_BACKLOG) + 1 :
            ]

    @property
    def has_waiting(self) -> bool:
        """Whether lines wait."""
        return bool(self._waiting)

    def write(self) -> None:
        """Write all waiting lines, or none, at `position`, and make them survive a crash of the machine."""
        if not self._waiting:
            return
        file = self._file
        assert file is not None
        length = os.fstat(file.fileno()).st_size
        try:
            try:
                write_all(file, self._waiting)
                os.fsync(file.fileno())
            except OSError:
                file.truncate(length)
                raise
        except OSError as error:
            raise self._refused(error) from None
        self._waiting = b""

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()

    def _opened(self) -> io.FileIO:
        """The file that has the name now, locked."""
        if self._file is None or not self._has_name(self._file):
            self.close()
            self._file = open_own(self.path, _OWN, "a log of a monitor")
            take_lock(self._file, f"{self.path}: another monitor writes it")
        return self._file

    def _has_name(self, file: io.FileIO) -> bool:
        try:
            return os.path.samestat(self.path.stat(), os.fstat(file.fileno()))
        except OSError:
            return False

    def _refused(self, error: OSError) -> StoreError:
        return StoreError(f"{self.path}: cannot be written: {reason(error)}")


def _unwritten(position: Position, log: io.FileIO) -> bytes:
    """The waiting lines of a stored position that are not in its file, also if that was renamed since.

    Of a file that is gone or was cut, all are taken as written. A torn line at the end of `log` is cut off.
    """
    waiting: bytes = position["waiting"].encode()
    file = found_again(Path(position["path"]), position)
    if file is None:
        return b""
    tail, is_log = file.read(len(waiting) + 1), os.path.samestat(file.status, os.fstat(log.fileno()))
    file.close()
    pairs = zip(tail.splitlines(True), waiting.splitlines(True), strict=False)
    n_written = sum(len(line) for line, _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
    if waiting.startswith(tail) and is_log:
        log.truncate(int(position["offset"]) + n_written)
    return waiting[n_written:]
