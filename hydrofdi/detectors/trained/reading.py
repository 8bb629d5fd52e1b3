"""Strict reading of detector files: everything is validated and nothing is executed."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.detectors.trained.consistency import inconsistencies
from hydrofdi.detectors.trained.file import SCHEMA, VERSION, DetectorFile
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import describe_error
from hydrofdi.settings.validation import known_keys
from hydrofdi.settings.yaml_source import dotted

MOST_BYTES = 2**20
"""Maximum size of a detector file [bytes]."""

_MOST_DIGITS, _MOST_SHOWN = 18, 200
_NUMBERS_PER_LINE = re.compile(r"\[\n\s+([-+\d.eE,\snul]+?)\n\s*\]")
"""A list of numbers, one per line; JSON strings cannot contain line breaks."""


def detector_text(file: DetectorFile) -> str:
    """Detector file as readable JSON: SI, lists of numbers on one line."""
    record = file.model_dump(mode="json", by_alias=True)
    text = json.dumps(record, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    return _NUMBERS_PER_LINE.sub(lambda found: "[" + " ".join(found[1].split()) + "]", text)


def load_detector(path: Path) -> DetectorFile:
    """Read a trained detector.

    Parameters
    ----------
    path : Path

    Raises
    ------
    ConfigError
        The file cannot be read, is not a detector file, is inconsistent, or was made for another version of
        hydrofdi or of its indicator.
    """
    text = _read(path)
    try:
        data = json.loads(
            text, object_pairs_hook=_mapping, parse_int=_integer, parse_float=_number, parse_constant=_number
        )
    except RecursionError:
        raise ConfigError(f"{path}: is nested too deeply") from None
    except ValueError as error:
        raise ConfigError(f"{path}: is not a detector file: {_shown(str(error))}") from None
    _require_known_form(path, data)
    try:
        file = DetectorFile.model_validate_json(text, strict=True)
    except ValidationError as errors:
        raise ConfigError([_mistake(path, error) for error in errors.errors()]) from None
    if mistakes := [
        Issue(_shown(each.message), _shown(each.where), str(path)) for each in inconsistencies(file)
    ]:
        raise ConfigError(mistakes)
    return file


def is_detector(path: Path) -> bool:
    """Whether a file declares itself a detector file, of any version."""
    try:
        data = json.loads(_read(path))
    except (ConfigError, ValueError, RecursionError):
        return False
    return isinstance(data, dict) and data.get("schema") == SCHEMA


def _read(path: Path) -> str:
    if path.exists() and not path.is_file():
        raise ConfigError(f"{path}: is not a regular file")
    try:
        with open(path, "rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}") from None
    if len(content) > MOST_BYTES:
        raise ConfigError(f"{path}: is larger than {MOST_BYTES >> 20} MiB, so it is not a detector file")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not a text file in UTF-8") from None


def _require_known_form(path: Path, data: Any) -> None:
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise ConfigError(f'{path}: is not a detector file; those contain "schema": "{SCHEMA}"')
    version = data.get("version")
    if type(version) is not int or version != VERSION:
        raise ConfigError(
            [
                Issue(
                    f"this hydrofdi reads version {VERSION}, not {_shown(repr(version))};"
                    " train the detector again",
                    "version",
                    str(path),
                )
            ]
        )


def _mapping(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    mapping = dict(pairs)
    if len(mapping) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"key {twice!r} is given twice")
    return mapping


def _integer(text: str) -> int:
    if len(text) > _MOST_DIGITS:
        raise ValueError(f"a number has {len(text)} digits")
    return int(text)


def _number(text: str) -> float:
    value = float(text)
    if value - value != 0.0:
        raise ValueError(f"{text} is not finite")
    return value


def _mistake(path: Path, error: Any) -> Issue:
    place = tuple(part for part in error["loc"] if part != "[key]")
    text = describe_error(error, known_keys(DetectorFile, place[:-1]))
    return Issue(_shown(text), _shown(dotted(place)), str(path))


def _shown(text: str) -> str:
    """Text from a file, shortened to one line."""
    line = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in text)
    return line if len(line) <= _MOST_SHOWN else f"{line[:_MOST_SHOWN]}…"
