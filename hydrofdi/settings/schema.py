"""The JSON Schema of a section, with the texts below its fields; only pages and schemas need them."""

from __future__ import annotations

import ast
import inspect
import sys
import typing
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic import BaseModel

from hydrofdi.settings.quantities import Section


def described_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a file that contains a section; field texts and units included."""
    schema = model.model_json_schema()
    sections = {section.__name__: section for section in _sections(model)}
    for name, definition in [(model.__name__, schema), *schema["$defs"].items()]:
        if name not in sections:
            continue
        for field, text in field_texts(sections[name]).items():
            key = sections[name].model_fields[field].alias or field
            described = definition["properties"][key] | {"description": text}
            definition["properties"][key] = dict(sorted(described.items()))
        if sections[name].short_forms:
            schema["$defs"][name] = {"anyOf": [definition, *sections[name].short_forms]}
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


def field_texts(model: type[BaseModel]) -> dict[str, str]:
    """Field → its docstring, those of the bases included; read from the source, when it is needed."""
    texts = {}
    for base in reversed(model.__mro__):
        if not issubclass(base, BaseModel) or base is BaseModel:
            continue
        for field, text in pairwise(_definitions(base.__module__)[base.__name__].body):
            match field, text:
                case ast.AnnAssign(target=ast.Name(name)), ast.Expr(value=ast.Constant(value=str(words))):
                    texts[name] = inspect.cleandoc(words)
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _definitions(module: str) -> dict[str, ast.ClassDef]:
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
