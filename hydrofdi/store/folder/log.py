"""Structured log of an experiment: ``run.log``, one JSON object per line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hydrofdi.errors import StoreError
from hydrofdi.store.files import reason
from hydrofdi.store.folder.provenance import now

_FILE = "run.log"


class RunLog:
    """Appends events to the log in an experiment's folder."""

    def __init__(self, directory: Path) -> None:
        self._path = directory / _FILE

    def write(self, event: str, **details: Any) -> None:
        """Append one event with a time stamp.

        Raises
        ------
        StoreError
            The log cannot be written.
        """
        line = json.dumps({"time": now(), "event": event, **details})
        try:
            with open(self._path, "a", encoding="utf-8") as file:
                file.write(line + "\n")
        except OSError as error:
            raise StoreError(f"{self._path}: cannot be written: {reason(error)}") from None
