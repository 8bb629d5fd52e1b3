"""What a detector shall be: from a YAML file, and from the command line on top of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.settings.extending import overlay, read_extended
from hydrofdi.settings.mistakes import describe_error, nearest
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source

_INDICATORS = "indicators"


def stated_detector(file: Path | None, options: Mapping[KeyPath, tuple[str, Any]]) -> DetectorConfig:
    """A detector before it is trained.

    Parameters
    ----------
    file : path, optional
        YAML with the keys of `DetectorConfig`. It may extend others, and may hold ``indicators:`` instead of
        ``indicator:`` and ``options:``; then ``indicator`` is the label of one of them.
    options : mapping
        Key → option of the command line, and its value; they win.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    source = Source({}) if file is None else read_extended(file, "a detector before it is trained")
    overlay(source, _given(options))
    chosen = source.data.pop(_INDICATORS, None)
    if chosen is not None:
        _choose(chosen, source)
    config = validated(DetectorConfig, source)
    _require_sound(config, source)
    return config


def _given(options: Mapping[KeyPath, tuple[str, Any]]) -> Source:
    source = Source({})
    for path, (option, value) in options.items():
        section = source.data
        for part in path[:-1]:
            section = section.setdefault(part, {})
        section[path[-1]] = value
        source.origins[path] = option
    return source


def _choose(chosen: Any, source: Source) -> None:
    """Take the one that is asked for from ``indicators:``."""
    made = make_indicators(chosen, source, (_INDICATORS,))
    label = source.data.get("indicator") or next(iter(made))
    if "options" in source.data:
        raise ConfigError([source.mistake(("options",), "stand under the label in 'indicators:'")])
    if label not in made or ("indicator" not in source.data and len(made) > 1):
        hint = nearest(str(label), [*made]) if label not in made else f"; known are {', '.join(made)}"
        raise ConfigError([source.mistake((_INDICATORS,), f"say which one is meant with --indicator{hint}")])
    source.data["indicator"] = made[label].name
    source.data["options"] = made[label].options.model_dump()


def _require_sound(config: DetectorConfig, source: Source) -> None:
    try:
        sound_indicator(config.indicator, config.options)
    except ConfigError as error:
        raise ConfigError([source.mistake(("indicator",), each.message) for each in error.mistakes]) from None
    except ValidationError as errors:
        known = [*indicator_kind(config.indicator).Options.model_fields]
        raise ConfigError(
            [
                source.mistake(("options", *error["loc"]), describe_error(error, known))
                for error in errors.errors()
            ]
        ) from None
