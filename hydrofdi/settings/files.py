"""Settings files: YAML as plain data that remembers its lines, the ready ones, and strict models of them."""

from __future__ import annotations

import difflib
import json
import os
import re
from collections.abc import Callable, Collection, Container, Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import takewhile
from pathlib import Path, PurePath
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import brief, describe_error, nearest

Keys = tuple[str | int, ...]

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
    origins: dict[Keys, str] = field(default_factory=dict)
    mistakes: list[Issue] = field(default_factory=list)

    def origin(self, path: Keys) -> str:
        """Where the part at `path`, or the nearest part around it, came from."""
        while path and path not in self.origins:
            path = path[:-1]
        return self.origins.get(path, "")

    def mistake(self, path: Keys, message: str) -> Issue:
        """A mistake at `path`."""
        return Issue(message, dotted(path), self.origin(path))

    def report(self, path: Keys, message: str) -> None:
        """Collect a mistake at `path`."""
        self.mistakes.append(self.mistake(path, message))

    def move(self, old: Keys, new: Keys) -> None:
        """Keep where the part at `old`, and what is in it, came from, as the origin of `new`."""
        for path in [path for path in self.origins if path[: len(old)] == old]:
            self.origins[(*new, *path[len(old) :])] = self.origins[path]


def dotted(path: Keys) -> str:
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
    """The data in a YAML text, None if it contains none; mistakes are collected, not raised.

    Scalars follow the core schema of YAML 1.2 (PyYAML speaks 1.1), and a repeated key is a mistake.
    """
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


def _construct(node: Any, path: Keys, file: str, source: Source) -> Any:
    source.origins[path] = f"{file}:{node.start_mark.line + 1}"
    if len(path) > _MOST_LEVELS or len(source.origins) > _MOST_PARTS:
        raise RecursionError
    if node.id == "mapping":
        return _construct_mapping(node, path, file, source)
    if node.id == "sequence":
        return [_construct(item, (*path, index), file, source) for index, item in enumerate(node.value)]
    return node.value if node.style in ("'", '"', "|", ">") else scalar(node.value)


def _construct_mapping(node: Any, path: Keys, file: str, source: Source) -> dict[str, Any]:
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


_FOLDER = "configs"
_PACKAGE = Path(__file__).resolve().parents[1]
_PLACES = (_PACKAGE / _FOLDER, _PACKAGE.parent / _FOLDER)
"""Where they lie in an installed package, and in a clone of the repository."""

_SCHEMA_LINE = "# yaml-language-server:"
_REFERENCE = re.compile(r"[\w./-]+\.(?:yaml|csv)\b")
_SENTENCE = re.compile(r".*?[.?!](?=\s|$)")


def located(path: Path, folder: Path = Path()) -> Path:
    """The file that a path or name means."""
    here = folder / path
    for own in (here, Path(f"{here}.yaml")):
        if os.path.exists(own) and not os.path.isdir(own):
            return own
    return _ready(path) or here


def _ready(path: Path) -> Path | None:
    parts = path.parts[1:] if path.parts[:1] == (_FOLDER,) else path.parts
    if path.is_absolute() or not parts or ".." in parts:
        return None
    base = ready_folder().joinpath(*parts)
    files = (Path(f"{base}.yaml"), *([base] if base.suffix in (".yaml", ".csv") else []))
    return next((file for file in files if os.path.isfile(file)), None)


@cache
def ready_folder() -> Path:
    """Where the ready configurations lie."""
    return next((folder for folder in _PLACES if folder.is_dir()), _PLACES[0])


def ready_names() -> list[str]:
    """Their names, such as ``table3`` and ``delays/smoke``; those in no group first."""
    folder = ready_folder()
    names = (file.relative_to(folder).with_suffix("").as_posix() for file in folder.rglob("*.yaml"))
    return sorted(names, key=lambda name: ("/" in name, name))


def ready_hint(path: Path) -> str:
    """A hint for a path that does not exist: the ready configuration that it probably means, if any."""
    asked = path.with_suffix("").as_posix().removeprefix(f"{_FOLDER}/")
    names = ready_names()
    same = [name for name in names if Path(name).name == Path(asked).name]
    close = same if len(same) == 1 else difflib.get_close_matches(asked, names, n=1, cutoff=0.7)
    if close:
        return f"; did you mean {close[0]!r}?"
    return "" if path.suffix else "; 'hydrofdi configs' lists the ready ones"


def ready_summary(name: str) -> str:
    """The first sentence of a ready configuration's first comment."""
    comment = takewhile(lambda line: line.startswith("#"), _lines(name))
    lines = "\n".join(line.removeprefix("#").strip() for line in comment)
    text = lines.strip().partition("\n\n")[0].replace("\n", " ")
    sentence = _SENTENCE.match(text)
    return sentence.group() if sentence else text


def ready_copy(name: str) -> str:
    """The text of a ready configuration for any folder: the files that it names are named as ready ones."""
    home = (ready_folder() / name).parent

    def named(match: re.Match[str]) -> str:
        file = Path(os.path.normpath(home / match.group()))
        return file.relative_to(ready_folder()).as_posix() if file.is_file() else match.group()

    return "\n".join(_REFERENCE.sub(named, line) for line in _lines(name)) + "\n"


def _lines(name: str) -> list[str]:
    """The lines of a ready configuration, without the line for editors."""
    lines = (ready_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if not line.startswith(_SCHEMA_LINE)]


Kind = Literal["experiment", "measured", "monitor", "fleet", "detector"]


def schema(kind: Kind = "experiment") -> dict[str, Any]:
    """The JSON Schema of a kind of file, as ``hydrofdi schema`` prints it.

    Raises
    ------
    ConfigError
        There is no such kind.

    Examples
    --------
    >>> import hydrofdi
    >>> hydrofdi.schema("measured")["$schema"]
    'https://json-schema.org/draft/2020-12/schema'
    """
    if kind not in get_args(Kind):
        raise ConfigError(f"kind: {brief(kind)} is unknown{nearest(str(kind), get_args(Kind))}")
    file = ready_folder() / ("schema.json" if kind == "experiment" else f"{kind}-schema.json")
    content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return content


Model = TypeVar("Model", bound=BaseModel)

_KEY = re.compile(r"\b[a-z][a-z_0-9]*\.[a-z][a-z_0-9]*\b")


def read_yaml(file: Path, kind: str) -> Source:
    """The data of a YAML file, which must be a mapping."""
    source = parse_yaml(read_text(file, kind), str(file))
    if source.mistakes and source.data is None:
        raise ConfigError(source.mistakes)
    if source.data is not None and not isinstance(source.data, dict):
        raise ConfigError([source.mistake((), f"{kind} contains 'key: value' pairs")])
    return source


def validated(model: type[Model], source: Source) -> Model:
    """The model that data describe."""
    try:
        valid = model.model_validate(source.data)
    except ValidationError as errors:
        source.mistakes.extend(_mistake(model, source, error) for error in errors.errors())
    if source.mistakes:
        raise ConfigError(sorted(source.mistakes, key=_reading_order))
    return valid


def _mistake(model: type[BaseModel], source: Source, error: Any) -> Issue:
    path = tuple(part for part in error["loc"] if part != "[key]")
    everywhere = [f"{part}.{key}" for part in model.model_fields for key in known_keys(model, (part,))]
    message = describe_error(error, known_keys(model, path[:-1]), everywhere)
    if error["type"] in ("model_type", "model_attributes_type") and (keys := known_keys(model, path)):
        message += f"; its keys are {', '.join(keys)}"
    return source.mistake(path, message) if path else _placed(source, message)


def _placed(source: Source, message: str) -> Issue:
    """A mistake between keys: at the first stated key, options first, with the places of the others."""
    named = dict.fromkeys(tuple(name.split(".")) for name in _KEY.findall(message))
    places = {path: source.origins[path] for path in named if path in source.origins}
    if not places:
        return source.mistake((), message)
    first, *others = sorted(places, key=lambda path: not places[path].startswith("settings "))
    elsewhere = ", ".join(f"{dotted(path)} is in {places[path]}" for path in others)
    return Issue(f"{message} ({elsewhere})" if elsewhere else message, origin=places[first])


def read_text(file: Path, kind: str) -> str:
    """The text of a file, which should be `kind`."""
    try:
        return file.read_text(encoding="utf-8")
    except IsADirectoryError:
        raise ConfigError(f"{file}: is a directory, not {kind}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{file}: is not a text file in UTF-8") from None
    except FileNotFoundError:
        raise ConfigError(f"{file}: no such file{ready_hint(file)}") from None
    except OSError as error:
        raise ConfigError(f"{file}: {error.strerror}") from None


def _reading_order(mistake: Issue) -> tuple[str, int]:
    file, _, line = mistake.origin.rpartition(":")
    return (file, int(line)) if line.isdigit() else (mistake.origin, 0)


def known_keys(model: Any, path: Keys) -> list[str]:
    """The keys of the section at a path within a model; none if there is no section."""
    section = _section_at(model, path)
    return list(section.model_fields) if _is_model(section) else []


def _section_at(model: Any, path: Keys) -> Any:
    """The section at a path within a model; None where there is none."""
    parts = iter(path)
    for part in parts:
        if not isinstance(part, int):
            field = model.model_fields.get(part) if _is_model(model) else None
            model = _model_within(field.annotation) if field else None
            if field and get_origin(field.annotation) is dict:
                next(parts, None)
    return model


def _model_within(annotation: Any) -> Any:
    """The model in ``Model``, ``Model | None`` and ``list[Model]``."""
    candidates = [annotation, *getattr(annotation, "__args__", ())]
    return next((candidate for candidate in candidates if _is_model(candidate)), None)


def _is_model(candidate: Any) -> bool:
    return isinstance(candidate, type) and issubclass(candidate, BaseModel)


Merge = Callable[[Mapping[str, Any], Mapping[str, Any]], dict[str, Any]]


def merged(
    base: Mapping[str, Any],
    over: Mapping[str, Any],
    whole: Container[str] = (),
    exclusive: Collection[tuple[str, str]] = (),
) -> dict[str, Any]:
    """Both mappings merged, also within, but not values of `whole` keys; the second wins.

    Its ``null`` removes what is inherited, and its one of an exclusive pair replaces the other.
    """
    pairs = [pair for one, other in exclusive for pair in ((one, other), (other, one))]
    replaced = {other for key, other in pairs if key in over and other not in over}
    mixed = {key: value for key, value in base.items() if key not in replaced}
    for key, value in over.items():
        is_section = isinstance(mixed.get(key), dict) and key not in whole
        if value is None and key in mixed and (is_section or key in whole):
            del mixed[key]
            continue
        both = is_section and isinstance(value, dict)
        mixed[key] = merged(mixed[key], value, whole, exclusive) if both else value
    return mixed


def overlay(base: Source, over: Source, merge: Merge = merged) -> None:
    """Lay a source over another; its keys win."""
    base.data = merge(base.data, over.data)
    base.origins.update(over.origins)
    base.mistakes.extend(over.mistakes)


def write_new(file: Path, text: str) -> None:
    """Write a new file; an existing one stays."""
    try:
        with open(file, "x", encoding="utf-8") as new:
            new.write(text)
    except FileExistsError:
        raise ConfigError(f"{file}: already exists and was not changed; choose another name") from None
    except OSError as error:
        raise ConfigError(f"{file}: cannot be written: {error.strerror}") from None


def read_extended(
    file: Path,
    kind: str,
    prepare: Callable[[Source, Path], None] = lambda own, file: None,
    merge: Merge = merged,
    extending: tuple[Path, ...] = (),
    own: Source | None = None,
) -> Source:
    """A file on top of the files that it extends."""
    if own is None:
        file = located(file)
        if file.resolve() in extending:
            chain = " → ".join(path.name for path in (*extending, file.resolve()))
            raise ConfigError([Issue(f"the files extend each other: {chain}", "extends", str(file))])
        own = read_yaml(file, kind)
    own.data = own.data or {}
    prepare(own, file)
    parents = own.data.pop("extends", [])
    parents = [parents] if isinstance(parents, str) else parents
    if not isinstance(parents, list) or not all(isinstance(parent, str) for parent in parents):
        raise ConfigError([own.mistake(("extends",), "expected the path of a file, or a list of paths")])
    whole = Source({})
    for parent in parents:
        path = located(Path(parent), file.parent)
        if not path.exists():
            hint = ready_hint(Path(parent))
            raise ConfigError([own.mistake(("extends",), f"{path}: no such file{hint}")])
        overlay(whole, read_extended(path, kind, prepare, merge, (*extending, file.resolve())), merge)
    overlay(whole, own, merge)
    return whole
