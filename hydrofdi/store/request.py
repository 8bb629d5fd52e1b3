"""The requested configuration, stored in an experiment's folder so that a sweep can be resumed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.experiment import STORED
from hydrofdi.errors import StoreError
from hydrofdi.settings.messages import describe_error
from hydrofdi.store.files import reason, write_whole_text

REQUEST_FILE = "experiment.json"
"""Name of the request file in an experiment's folder."""


def write_request(directory: Path, experiment: ExperimentConfig) -> None:
    """Store the resolved configuration of a sweep.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    write_whole_text(directory / REQUEST_FILE, experiment.model_dump_json(indent=2) + "\n")


def require_same_experiment(directory: Path, experiment: ExperimentConfig) -> None:
    """Check that a folder does not contain an experiment with a different name.

    Raises
    ------
    StoreError
        It contains another experiment.
    """
    if directory.exists() and not directory.is_dir():
        raise StoreError(f"{directory}: is a file, not a folder; give another 'out'")
    if not (directory / REQUEST_FILE).exists():
        return
    held = read_request(directory).name
    if held != experiment.name:
        raise StoreError(
            f"{directory}: contains the experiment {held!r}, not {experiment.name!r}; give another 'out'"
        )


def request_record(directory: Path) -> dict[str, Any]:
    """The latest request as written, in SI; empty if there is none.

    Raises
    ------
    StoreError
        The file cannot be read.
    """
    path = directory / REQUEST_FILE
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError) as error:
        raise StoreError(f"{path}: cannot be read: {error}") from None


def read_request(directory: Path) -> ExperimentConfig:
    """The resolved configuration of the latest sweep on a folder.

    Raises
    ------
    StoreError
        The file is missing or cannot be read.
    """
    path = directory / REQUEST_FILE
    try:
        return stored_experiment(path.read_text(encoding="utf-8"), str(path))
    except FileNotFoundError:
        raise StoreError(
            f"{directory}: is not the folder of an experiment (it has no {REQUEST_FILE})"
        ) from None
    except StoreError:
        raise
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: cannot be read: {reason(error)}") from None


def stored_experiment(text: str, place: str) -> ExperimentConfig:
    """Parse a resolved configuration.

    Raises
    ------
    StoreError
        The text is not a resolved configuration; the message begins with the place.
    """
    try:
        return ExperimentConfig.model_validate_json(text, context=STORED)
    except ValidationError as error:
        first = error.errors()[0]
        why = ": ".join(filter(None, (".".join(map(str, first["loc"])), describe_error(first))))
        raise StoreError(f"{place}: cannot be read: {why}") from None
