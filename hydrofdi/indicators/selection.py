"""Selection of indicators and their options."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators.choice import chosen_options
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.registry import indicator_kind, indicator_names, sound_indicator
from hydrofdi.settings.extending import read_extended
from hydrofdi.settings.messages import describe_error
from hydrofdi.settings.ready import located
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source

_SUFFIXES = (".yaml", ".yml")

_KIND_HINT = "; under a label of your own, add 'kind: NAME'"


def load_indicators(text: str) -> dict[str, Indicator[Any]]:
    """Make the indicators named in a file or a list.

    Parameters
    ----------
    text : str
        ``NAME,…``, ``all``, or the path of a YAML file with ``indicators:``, which may extend others;
        or the name of such a ready one.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    parts, is_file = [part.strip() for part in text.split(",")], located(Path(text)).is_file()
    if len(parts) > 1 and not is_file and any(part.endswith(_SUFFIXES) for part in parts):
        raise ConfigError(f"{text}: give one file; its 'indicators:' may contain several labels")
    if text.endswith(_SUFFIXES) or is_file:
        source = read_extended(Path(text), "a file of indicators")
        within: KeyPath = ("indicators",)
        if "indicators" not in source.data:
            raise ConfigError([Issue("has no 'indicators:'", origin=text)])
        return make_indicators(source.data["indicators"], source, within)
    return make_indicators(text)


def make_indicators(
    chosen: Any, source: Source | None = None, within: KeyPath = ()
) -> dict[str, Indicator[Any]]:
    """Label → indicator, in the order given.

    Parameters
    ----------
    chosen : str, sequence of str, or mapping
        ``all``, a name or ``NAME,…``; names; or label → options. The label is the name of the indicator,
        unless the options contain ``kind``: so one indicator can be measured twice.
    source : Source, optional
        Source of the choice, for line numbers of mistakes.
    within : tuple of str
        Key path of the choice in its source.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    source = Source(chosen) if source is None else source
    return make_chosen(chosen_options(chosen, source, within), source, within)


def make_chosen(
    options: Mapping[str, Any], source: Source, within: KeyPath = ()
) -> dict[str, Indicator[Any]]:
    """Make indicators: label → indicator.

    Raises
    ------
    ConfigError
        One or more mistakes, including those collected in `source`.
    """
    made = {label: _make(label, given, source, (*within, label)) for label, given in options.items()}
    if source.mistakes:
        raise ConfigError(source.mistakes)
    return {label: indicator for label, indicator in made.items() if indicator is not None}


def _make(label: str, given: Any, source: Source, path: KeyPath) -> Indicator[Any] | None:
    options = {} if given is None else given
    if not isinstance(options, Mapping):
        source.mistakes.append(source.mistake(path, f"expected 'option: value' pairs; found {options!r}"))
        return None
    options = dict(options)
    is_named = "kind" in options
    try:
        name = str(options.pop("kind", label))
        return sound_indicator(name, options)
    except ConfigError as error:
        hint = "" if is_named or label in indicator_names() else _KIND_HINT
        source.mistakes.extend(source.mistake(path, f"{each.message}{hint}") for each in error.mistakes)
    except ValidationError as errors:
        fields = [*indicator_kind(name).Options.model_fields]
        source.mistakes.extend(
            source.mistake((*path, *error["loc"]), describe_error(error, fields)) for error in errors.errors()
        )
    return None
