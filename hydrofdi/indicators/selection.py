"""Which indicators are measured, with which options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.errors import ConfigError, Mistake
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.registry import indicator_kind, indicator_names
from hydrofdi.settings.mistakes import describe_error
from hydrofdi.settings.validation import read_yaml
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source


def load_indicators(text: str) -> dict[str, Indicator[Any]]:
    """The indicators that a file or a list names.

    Parameters
    ----------
    text : str
        ``NAME,…``, ``all``, or the path of a YAML file with an ``indicators:`` mapping.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    if text.endswith((".yaml", ".yml")) or Path(text).is_file():
        source = read_yaml(Path(text), "a file of indicators")
        within: KeyPath = ("indicators",)
        if not isinstance(source.data, dict) or "indicators" not in source.data:
            raise ConfigError([Mistake("has no 'indicators:'", origin=text)])
        return make_indicators(source.data["indicators"], source, within)
    names = indicator_names() if text == "all" else [name.strip() for name in text.split(",") if name.strip()]
    if not names:
        raise ConfigError("--indicators names none; 'hydrofdi indicators' lists them")
    return make_indicators(names)


def make_indicators(
    chosen: Mapping[str, Any] | Sequence[str], source: Source | None = None, within: KeyPath = ()
) -> dict[str, Indicator[Any]]:
    """Label → indicator, in the order given.

    Parameters
    ----------
    chosen : mapping or sequence of str
        Names, or label → options. The label is the indicator's name, unless ``kind`` among the options
        gives it: so one indicator can be measured twice.
    source : Source, optional
        What the choice was read from, for the lines of mistakes.
    within : tuple of str
        Key of the choice in its source.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    source = Source(chosen) if source is None else source
    if isinstance(chosen, str) or not isinstance(chosen, Mapping | Sequence):
        raise ConfigError([source.mistake(within, "expected a list of names, or 'name: {options}' pairs")])
    options = chosen if isinstance(chosen, Mapping) else {name: {} for name in chosen}
    made = {label: _make(str(label), given, source, (*within, label)) for label, given in options.items()}
    if source.mistakes:
        raise ConfigError(source.mistakes)
    return {label: indicator for label, indicator in made.items() if indicator is not None}


def _make(label: str, given: Any, source: Source, path: KeyPath) -> Indicator[Any] | None:
    options = {} if given is None else given
    if not isinstance(options, Mapping):
        source.mistakes.append(source.mistake(path, f"expected 'option: value' pairs; found {options!r}"))
        return None
    options = dict(options)
    try:
        kind = indicator_kind(str(options.pop("kind", label)))
        return kind(kind.Options.model_validate(options))
    except ConfigError as error:
        source.mistakes.extend(source.mistake(path, mistake.message) for mistake in error.mistakes)
    except ValidationError as errors:
        source.mistakes.extend(
            source.mistake((*path, *error["loc"]), describe_error(error, [*kind.Options.model_fields]))
            for error in errors.errors()
        )
    return None
