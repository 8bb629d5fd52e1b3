"""Runs without a result: they raised, took too long, or their worker was killed."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from hydrofdi.store.files import write_whole_text

_FOLDER = "failures"


@dataclass(frozen=True)
class Failure:
    """A run without a result.

    Attributes
    ----------
    run_id : str
    status : str
        ``error``, ``timeout`` or ``killed``.
    message : str
        One sentence.
    log : str
        Output of the worker, e.g. a traceback.
    """

    run_id: str
    status: str
    message: str
    log: str = ""


def write_failure(directory: Path, failure: Failure) -> None:
    """Store a failure below an experiment's folder.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    write_whole_text(directory / _FOLDER / f"{failure.run_id}.json", json.dumps(asdict(failure), indent=2))


def read_failures(directory: Path) -> dict[str, Failure]:
    """Identity of a run → stored failure; unreadable files are ignored."""
    failures = {}
    for path in sorted((directory / _FOLDER).glob("*.json")):
        try:
            failure = Failure(**json.loads(path.read_text()))
        except (OSError, ValueError, TypeError):
            continue
        failures[failure.run_id] = failure
    return failures


def forget_failure(directory: Path, run_id: str) -> None:
    """Delete the stored failure of a run, if any."""
    (directory / _FOLDER / f"{run_id}.json").unlink(missing_ok=True)
