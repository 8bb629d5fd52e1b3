"""What an experiment asks for now, against what the results in its folder were made of."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.renamed_keys import with_present_keys
from hydrofdi.config.sections.csv_input import without_contents
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.store.folder.provenance import read_provenance

_PHYSICS = "physics version"


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
    before = _flat(with_present_keys(made["configuration"]))
    now = _flat(without_contents(json.loads(asked.model_dump_json())))
    before[_PHYSICS], now[_PHYSICS] = made.get("physics", PHYSICS_VERSION), PHYSICS_VERSION
    return {
        key: (before.get(key), now.get(key))
        for key in dict.fromkeys([*before, *now])
        if before.get(key) != now.get(key) and not key.startswith("units: ")
    }


def _flat(value: Any, path: str = "") -> dict[str, Any]:
    """Values by dotted keys; lists, and what is empty, stay whole."""
    if not isinstance(value, dict) or not value:
        return {path: value} if value not in ({}, []) else {}
    flat: dict[str, Any] = {}
    for key, content in value.items():
        flat |= _flat(content, f"{path}: {key}" if "." in key else f"{path}.{key}".lstrip("."))
    return flat
