"""The JSON Schema of a section, with the texts of its fields."""

from __future__ import annotations

import typing
from typing import Any

from hydrofdi.settings.docstrings import field_texts
from hydrofdi.settings.quantities import Section


def described_schema(model: type[Section], title: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a file that contains a section; field texts and units included.

    Parameters
    ----------
    model : type of Section
    title : str
        What the file is.
    """
    schema = model.model_json_schema()
    sections = {section.__name__: section for section in _sections(model)}
    for name, definition in [(model.__name__, schema), *schema["$defs"].items()]:
        for field, text in field_texts(sections[name]).items() if name in sections else ():
            key = sections[name].model_fields[field].alias or field
            described = definition["properties"][key] | {"description": text}
            definition["properties"][key] = dict(sorted(described.items()))
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        **{key: value for key, value in schema.items() if key != "title"},
    }


def _sections(annotation: Any, found: set[type[Section]] | None = None) -> set[type[Section]]:
    """All sections in an annotation, and in the fields of sections."""
    found = set() if found is None else found
    inner = typing.get_args(annotation)
    if isinstance(annotation, type) and issubclass(annotation, Section) and annotation not in found:
        found.add(annotation)
        inner = tuple(info.annotation for info in annotation.model_fields.values())
    for part in inner:
        _sections(part, found)
    return found
