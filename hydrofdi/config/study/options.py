"""Options given next to the other keys of a section: moved to where its model has them, and checked."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from hydrofdi.settings.messages import describe_error
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.yaml_source import Path, Source


def move_options(
    source: Source, section: dict[str, Any], path: Path, fields: Iterable[str], model: type[Section]
) -> None:
    """Move all but some fields of a section under ``options``; what the model refuses is a mistake."""
    known = list(fields)
    beside = {name: section.pop(name) for name in [name for name in section if name not in known]}
    within = section.get("options", {})
    if not isinstance(within, dict):
        return
    options = section["options"] = within | beside
    try:
        model.model_validate(options)
    except ValidationError as errors:
        names = [*known, *model.model_fields]
        for error in errors.errors():
            place = error["loc"] if error["loc"][0] in beside else ("options", *error["loc"])
            source.mistakes.append(source.mistake((*path, *place), describe_error(error, names)))
