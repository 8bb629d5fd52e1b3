"""The file that a monitor goes on from after a restart."""

from __future__ import annotations

import hashlib
import json
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.errors import StoreError
from hydrofdi.monitor.sources import Position
from hydrofdi.records.streams import State
from hydrofdi.store.files import reason, whole_file
from hydrofdi.store.folder.lock import file_lock

SCHEMA, VERSION = "hydrofdi.monitor-state", 1

_HEADER = "header"


@dataclass(frozen=True)
class Stored:
    """What a monitor knows behind a step.

    Attributes
    ----------
    state : mapping of str to ndarray
        Of the watch.
    position : mapping
        Where the source goes on.
    log : mapping
        Where the log goes on; empty without one.
    """

    state: State
    position: Position
    log: Position


class StateFile:
    """One file: arrays, and a header that says whose they are. It is replaced whole, or not at all.

    Parameters
    ----------
    path : Path
    detector : DetectorFile
    source : str
        Name of the source.
    """

    def __init__(self, path: Path, detector: DetectorFile, source: str) -> None:
        self.path = path
        self._owner = {"schema": SCHEMA, "version": VERSION, "detector": digest(detector), "source": source}

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold it for this process alone.

        Raises
        ------
        StoreError
            Another monitor uses it, or its folder cannot be written.
        """
        with file_lock(
            self.path.with_name(f".{self.path.name}.lock"), f"{self.path}: another monitor uses it"
        ):
            yield

    def read(self) -> Stored | None:
        """What was stored; None where nothing was yet.

        Raises
        ------
        StoreError
            It is damaged, or belongs to another detector or source.
        """
        if not self.path.exists():
            return None
        try:
            with np.load(self.path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            header = json.loads(arrays.pop(_HEADER).tobytes())
            self._require_own(header)
            return Stored(arrays, header["position"], header["log"])
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, StoreError):
                raise
            raise StoreError(f"{self.path}: is damaged; remove it to begin anew: {reason(error)}") from None

    def write(self, stored: Stored) -> None:
        """Replace it; afterwards it survives a crash of the machine.

        Raises
        ------
        StoreError
            It cannot be written: the disk is full, say.
        """
        header = {**self._owner, "position": dict(stored.position), "log": dict(stored.log)}
        text = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
        with whole_file(self.path) as aside, open(aside, "wb") as file:
            np.savez(file, allow_pickle=False, **{_HEADER: text}, **stored.state)

    def _require_own(self, header: dict[str, Any]) -> None:
        words = {
            "schema": "is no state of a monitor",
            "version": "was written by another version of hydrofdi",
            "detector": "belongs to another detector",
            "source": f"belongs to another source, {header.get('source')}",
        }
        for key, value in self._owner.items():
            if header.get(key) != value:
                advice = "give another file with --state, or remove this one to begin anew"
                raise StoreError(f"{self.path}: {words[key]}; {advice}")


def digest(detector: DetectorFile) -> str:
    """What tells detectors apart: all of the file but who made it, and when."""
    text = detector.model_dump_json(by_alias=True, exclude={"made"})
    return hashlib.sha256(text.encode()).hexdigest()
