"""Configuration of a detector from a YAML file or mapping, with keywords or options that override it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.detectors.charts.registry import chart_kind, make_chart
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.settings.extending import extended, overlay, read_extended
from hydrofdi.settings.messages import describe_error, listed, nearest
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source, dotted, plain

_INDICATORS = "indicators"


def stated_detector(
    file: Path | Mapping[str, Any] | None, options: Mapping[KeyPath, tuple[str, Any]]
) -> DetectorConfig:
    """Read the configuration of a detector.

    Parameters
    ----------
    file : path or mapping, optional
        YAML file or equivalent mapping with the keys of `DetectorConfig`. It may extend other files, and may
        contain ``indicators:`` instead of ``indicator:`` and ``options:``; then ``indicator`` is one of their
        labels.
    options : mapping
        Key → keyword or option, and its value; these override the file.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    source = _read(file)
    overlay(source, _given(options))
    chosen = source.data.pop(_INDICATORS, None)
    if chosen is not None:
        _choose(chosen, source)
    config = validated(DetectorConfig, source)
    _require_sound(config, source)
    return config


def _read(file: Path | Mapping[str, Any] | None) -> Source:
    kind = "a detector before it is trained"
    if file is None:
        return Source({})
    if isinstance(file, Mapping):
        return extended(Source(plain(file)), Path("the mapping"), kind)
    return read_extended(file, kind)


def _given(options: Mapping[KeyPath, tuple[str, Any]]) -> Source:
    source = Source({})
    for path, (option, value) in options.items():
        section = source.data
        for part in path[:-1]:
            section = section.setdefault(part, {})
        section[path[-1]] = value
        if option != dotted(path):
            source.origins[path] = option
    return source


def _choose(chosen: Any, source: Source) -> None:
    """Replace ``indicators:`` by the chosen indicator."""
    made = make_indicators(chosen, source, (_INDICATORS,))
    label = source.data.get("indicator") or next(iter(made))
    if "options" in source.data:
        raise ConfigError([source.mistake(("options",), "belong under the label in 'indicators:'")])
    if label not in made or ("indicator" not in source.data and len(made) > 1):
        hint = nearest(str(label), [*made]) if label not in made else listed([*made])
        raise ConfigError([source.mistake((_INDICATORS,), f"choose an indicator{hint}")])
    source.data["indicator"] = made[label].name
    source.data["options"] = made[label].options.model_dump(exclude_unset=True)


def _require_sound(config: DetectorConfig, source: Source) -> None:
    """Check that indicator and chart can be made.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    mistakes = [*_mistakes_of("indicator", sound_indicator, config.indicator, config.options, source, ())]
    if not mistakes:
        mistakes += _mistakes_of_score(config, source)
    if config.chart is not None:
        named, options = config.chart.chart, config.chart.options
        mistakes += _mistakes_of("chart", make_chart, named, options, source, ("chart",))
    if mistakes:
        raise ConfigError(mistakes)


def _mistakes_of(
    key: str,
    make: Callable[[str, Mapping[str, Any]], Any],
    name: str,
    options: Mapping[str, Any],
    source: Source,
    within: KeyPath,
) -> Iterator[Issue]:
    try:
        make(name, options)
    except ConfigError as faulty:
        yield from (source.mistake((*within, key), each.message) for each in faulty.mistakes)
    except ValidationError as errors:
        kind = chart_kind if within else indicator_kind
        known = [*kind(name).Options.model_fields]
        for error in errors.errors():
            yield source.mistake((*within, "options", *error["loc"]), describe_error(error, known))


def _mistakes_of_score(config: DetectorConfig, source: Source) -> Iterator[Issue]:
    try:
        feature = feature_of(config)
    except ConfigError as faulty:
        yield source.mistake(("output",), str(faulty))
        return
    try:
        feature.direction(config.direction)
    except ConfigError as faulty:
        yield source.mistake(("direction",), str(faulty))
