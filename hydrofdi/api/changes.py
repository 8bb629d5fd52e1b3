"""What an experiment asks for now, against what the results in its folder were made of."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.folder.provenance import read_provenance
from hydrofdi.store.request import request_record

_PHYSICS = "physics version"
_MOST_NAMED = 3


def changes_since(directory: Path, asked: ExperimentConfig) -> dict[str, tuple[Any, Any]]:
    """Key → (value of the latest sweep that stored runs, value now), where they differ, in SI.

    Parameters
    ----------
    directory : Path
        Folder of the experiment.
    asked : ExperimentConfig
        What is asked for now.
    """
    made = next((record for record in reversed(read_provenance(directory)) if record.get("computed")), None)
    if made is None:
        return {}
    changes = _changes(made["configuration"], asked)
    physics = made.get("physics", PHYSICS_VERSION)
    return changes | ({} if physics == PHYSICS_VERSION else {_PHYSICS: (physics, PHYSICS_VERSION)})


def replaced_settings(directory: Path, asked: ExperimentConfig) -> str:
    """A sentence on settings of the experiment that a folder showed until now; empty if they are the same.

    Parameters
    ----------
    directory : Path
        Folder of the experiment.
    asked : ExperimentConfig
        What is asked for now.
    """
    shown = request_record(directory)
    keys = [*_changes(shown, asked)] if shown else []
    if not keys:
        return ""
    more = f" and {len(keys) - _MOST_NAMED} more" if len(keys) > _MOST_NAMED else ""
    return (
        f"{directory}: showed an experiment with another {', '.join(keys[:_MOST_NAMED])}{more}, and now shows"
        " this one; earlier runs are kept"
    )


def _changes(before: dict[str, Any], asked: ExperimentConfig) -> dict[str, tuple[Any, Any]]:
    """Key → (value before, value now), where they differ."""
    old = _flat(before)
    now = _flat(without_contents(json.loads(asked.model_dump_json())))
    return {
        key: (old.get(key), now.get(key))
        for key in dict.fromkeys([*old, *now])
        if old.get(key) != now.get(key) and not key.startswith("units: ")
    }


def _flat(value: Any, path: str = "") -> dict[str, Any]:
    """Values by dotted keys; lists, and what is empty, stay whole."""
    if not isinstance(value, dict) or not value:
        return {path: value} if value not in ({}, []) else {}
    flat: dict[str, Any] = {}
    for key, content in value.items():
        flat |= _flat(content, f"{path}: {key}" if "." in key else f"{path}.{key}".lstrip("."))
    return flat
