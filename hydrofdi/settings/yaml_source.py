"""YAML as plain data that remembers its lines.

Scalars follow the core schema of YAML 1.2 (PyYAML speaks 1.1), and a repeated key is a mistake.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Any

from hydrofdi.errors import Issue

Path = tuple[str | int, ...]

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_MOST_DIGITS = 300
"""Longer integers are read as floats, which may be infinite."""
_MOST_LEVELS, _MOST_PARTS = 20, 200_000
"""Limits of nesting and of size, which aliases to anchors can make endless."""
_SPECIAL = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf"), float("inf")),
    "-.inf": float("-inf"),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


@dataclass
class Source:
    """Data, the place of each part (path → ``file:line`` or option), and mistakes of the text itself."""

    data: Any = None
    origins: dict[Path, str] = field(default_factory=dict)
    mistakes: list[Issue] = field(default_factory=list)

    def origin(self, path: Path) -> str:
        """Where the part at `path`, or the nearest part around it, came from."""
        while path and path not in self.origins:
            path = path[:-1]
        return self.origins.get(path, "")

    def mistake(self, path: Path, message: str) -> Issue:
        """A mistake at `path`."""
        return Issue(message, dotted(path), self.origin(path))

    def report(self, path: Path, message: str) -> None:
        """Collect a mistake at `path`."""
        self.mistakes.append(self.mistake(path, message))

    def move(self, old: Path, new: Path) -> None:
        """Keep where the part at `old`, and what is in it, came from, as the origin of `new`."""
        for path in [path for path in self.origins if path[: len(old)] == old]:
            self.origins[(*new, *path[len(old) :])] = self.origins[path]


def dotted(path: Path) -> str:
    """A path as text, e.g. ``sweep.grid.fluid.bulk_modulus[1]``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def plain(value: Any) -> Any:
    """A value of Python as it would come from YAML: arrays and tuples as lists, paths as text; a copy."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, PurePath):
        return str(value)
    return value.tolist() if hasattr(value, "tolist") else value


def parse_yaml(text: str, file: str) -> Source:
    """The data in a YAML text, None if it contains none; mistakes are collected, not raised."""
    import yaml

    source = Source()
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
        source.data = None if node is None else _construct(node, (), file, source)
    except RecursionError:
        source.mistakes.append(Issue("nested too deeply, or too large", origin=file))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        source.mistakes.append(Issue(f"not valid YAML: {error.problem}", origin=f"{file}{line}"))
    except yaml.YAMLError as error:
        source.mistakes.append(Issue(f"not valid YAML: {error}".splitlines()[0], origin=file))
    return source


def _construct(node: Any, path: Path, file: str, source: Source) -> Any:
    source.origins[path] = f"{file}:{node.start_mark.line + 1}"
    if len(path) > _MOST_LEVELS or len(source.origins) > _MOST_PARTS:
        raise RecursionError
    if node.id == "mapping":
        return _construct_mapping(node, path, file, source)
    if node.id == "sequence":
        return [_construct(item, (*path, index), file, source) for index, item in enumerate(node.value)]
    return node.value if node.style in ("'", '"', "|", ">") else scalar(node.value)


def _construct_mapping(node: Any, path: Path, file: str, source: Source) -> dict[str, Any]:
    mapping: dict[str, Any] = {}
    for key_node, value_node in node.value:
        key = str(key_node.value)
        here = (*path, key)
        if key in mapping:
            origin = f"{file}:{key_node.start_mark.line + 1}"
            first = source.origin(here).rpartition(":")[2]
            source.mistakes.append(Issue(f"key given twice, first in line {first}", dotted(here), origin))
            continue
        mapping[key] = _construct(value_node, here, file, source)
        line = key_node.start_mark.line
        if value_node.id == "scalar":  # an alias has the line of its anchor
            line = min(line, value_node.start_mark.line)
        source.origins[here] = f"{file}:{line + 1}"
    return mapping


def yaml_text(content: Mapping[str, Any]) -> str:
    """Plain data as YAML, in its order."""
    import yaml

    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100)


def scalar(text: str) -> Any:
    """An unquoted YAML 1.2 scalar as None, bool, int, float or str."""
    if text in _SPECIAL:
        return _SPECIAL[text]
    if _INTEGER.fullmatch(text) and len(text) <= _MOST_DIGITS:
        return int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text
