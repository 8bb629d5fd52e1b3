"""Group and label of a record, from its path, its columns and its direction."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import PurePosixPath

_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
OWN_NAMES = ("folder", "file", "direction")
"""Names that every record has."""


def path_pattern(template: str) -> re.Pattern[str]:
    """The regular expression of a template of paths.

    Raises
    ------
    re.error
        The template is not a regular expression.
    """
    if not template or "(?P<" in template:
        return re.compile(f"(?:{template})$" if template else "")
    pieces = _FIELD.split(template)
    texts, names = [re.escape(piece) for piece in pieces[::2]], pieces[1::2]
    # a name ends where the text behind it first occurs; only the last one may have to look further
    fields = [f"(?P<{name}>[^/](?:(?!{text})[^/])*+)" for name, text in zip(names, texts[1:], strict=True)]
    fields[-1:] = [f"(?P<{name}>[^/]+?)" for name in names[-1:]]
    return re.compile("".join(a + b for a, b in zip(texts, [*fields, ""], strict=True)) + "$")


def names_of_path(place: str, pattern: re.Pattern[str]) -> dict[str, str] | None:
    """Name → value in a path; None if it does not match."""
    match = pattern.search(place)
    if match is None:
        return None
    path = PurePosixPath(place)
    own = {"folder": path.parent.name, "file": path.name}
    return own | {name: value or "" for name, value in match.groupdict().items()}


def fields_of(template: str) -> list[str]:
    """Names in braces in a template."""
    return _FIELD.findall(template)


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with its names replaced."""
    return _FIELD.sub(lambda match: values[match[1]], template)
