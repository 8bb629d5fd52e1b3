"""The file from which a monitor continues after a restart."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import StoreError
from hydrofdi.monitor.sources import Position
from hydrofdi.records.streams import State
from hydrofdi.store.files import reason, require_regular, whole_file
from hydrofdi.store.folder.lock import file_lock

SCHEMA, VERSION = "hydrofdi.monitor-state", 3
"""Raise the version when arrays of the state get another name or meaning."""


@dataclass(frozen=True)
class Stored:
    """The state of a monitor after a step.

    Attributes
    ----------
    state : mapping of str to ndarray
                State of the watch.
    position : mapping
        Where the source continues.
    log : mapping
        Where the log continues, and lines that it may not have yet; empty without one.
    """

    state: State
    position: Position
    log: Position


class StateFile:
    """One file that is replaced atomically: a checksum, a line that names its owner, and arrays.

    Parameters
    ----------
    path : Path
    detector : DetectorFile
    source : str
        Name of the source.
    """

    def __init__(self, path: Path, detector: DetectorFile, source: str) -> None:
        self.path = path.resolve()  # a link stays, what it leads to is replaced
        self._owner = {"schema": SCHEMA, "version": VERSION, "detector": digest(detector), "source": source}

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the file for this process.

        Raises
        ------
        StoreError
            It is not a regular file, another monitor uses it, or its folder cannot be written.
        """
        require_regular(self.path)
        lock = self.path.with_name(f".{self.path.name}.lock")
        with file_lock(lock, f"{self.path}: another monitor uses it"):
            yield

    def read(self) -> Stored | None:
        """The stored state; None if nothing is stored yet.

        Raises
        ------
        StoreError
            It is damaged, or belongs to another detector or source.
        """
        if not self.path.exists():
            return None
        try:
            checksum, _, content = self.path.read_bytes().partition(b"\n")
        except OSError as error:
            raise StoreError(f"{self.path}: cannot be read: {reason(error)}") from None
        try:
            if checksum != _checksum(content):
                raise ValueError
            line, _, body = content.partition(b"\n")
            header = json.loads(line)
            self._require_own(header)
            with np.load(io.BytesIO(body), allow_pickle=False) as arrays:
                return Stored(dict(arrays), dict(header["position"]), dict(header["log"]))
        except StoreError:
            raise
        except Exception:  # whatever a library raises on foreign content
            raise StoreError(
                f"{self.path}: is damaged, or not the state of a monitor; remove it to start from scratch"
            ) from None

    def write(self, stored: Stored) -> None:
        """Replace the file; the new state survives a crash of the machine.

        Raises
        ------
        StoreError
            It cannot be written, for example on a full disk, or the state contains more than plain arrays.
        """
        header = {**self._owner, "position": dict(stored.position), "log": dict(stored.log)}
        body = io.BytesIO()
        try:
            np.savez(body, allow_pickle=False, **stored.state)
            content = json.dumps(header).encode() + b"\n" + body.getvalue()
        except (TypeError, ValueError) as error:
            raise StoreError(f"{self.path}: cannot be stored: {reason(error)}") from None
        with whole_file(self.path) as aside:
            aside.write_bytes(_checksum(content) + b"\n" + content)

    def _require_own(self, header: dict[str, Any]) -> None:
        for key in ("version", "detector", "source"):
            if header.get(key) != self._owner[key]:
                advice = "give another file as 'state', or remove this one to start from scratch"
                raise StoreError(f"{self.path}: belongs to another {key}; {advice}")


def digest(detector: DetectorFile) -> str:
    """A digest of all of a detector file, except who made it, and when."""
    text = detector.model_dump_json(by_alias=True, exclude={"made"})
    return hashlib.sha256(text.encode()).hexdigest()


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
