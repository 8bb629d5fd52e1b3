"""Parsing of a choice of indicators: ``all``, names, or labels with options."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from hydrofdi.errors import ConfigError, IndicatorWarning
from hydrofdi.indicators.labels import label_mistake
from hydrofdi.indicators.registry import indicator_names, shadows, sound_indicator
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source


def chosen_options(chosen: Any, source: Source, within: KeyPath = ()) -> dict[str, Any]:
    """Label → options, for any form of choice; mistakes are collected in `source`."""
    for shadow in shadows():
        warnings.warn(shadow, IndicatorWarning, stacklevel=2)
    if isinstance(chosen, str) and chosen.strip() == "all":
        return {name: {} for name in _loadable_names()}
    given = [name.strip() for name in chosen.split(",")] if isinstance(chosen, str) else chosen
    is_unnamed = isinstance(chosen, str) and "" in given
    if not isinstance(given, Mapping | Sequence) or not given or is_unnamed:
        listed = "'hydrofdi indicators' lists them"
        message = f"expected 'all', names, or 'name: {{options}}' pairs; found {chosen!r}; {listed}"
        source.mistakes.append(source.mistake(within, message))
        return {}
    if not isinstance(given, Mapping):
        return _named(given, source, within)
    for label in given:
        if mistake := label_mistake(label):
            source.mistakes.append(source.mistake((*within, label), f"{label!r} {mistake}"))
    return {str(label): options for label, options in given.items() if label_mistake(label) is None}


def _named(given: Sequence[Any], source: Source, within: KeyPath) -> dict[str, Any]:
    names: dict[str, Any] = {}
    for place, item in enumerate(given):
        name = item.strip() if isinstance(item, str) else item
        message = ""
        if isinstance(name, Mapping):
            message = (
                "a list contains only names; with options, write 'indicators: {dwt: {}, modwt: {levels: 3}}'"
            )
        elif not isinstance(name, str) or not name:
            message = f"expected the name of an indicator; found {name!r}; 'hydrofdi indicators' lists them"
        elif name in names:
            message = f"{name!r} is named twice; give one a label of its own: 'LABEL: {{kind: {name}}}'"
        elif name == "all":
            message = "'all' cannot be combined with other names"
        if message:
            source.mistakes.append(source.mistake((*within, place), message))
        else:
            names[name] = {}
    return names


def _loadable_names() -> list[str]:
    """Names of all indicators that can be loaded; warn about the others."""
    names = []
    for name in indicator_names():
        try:
            sound_indicator(name)
            names.append(name)
        except ConfigError as error:
            warnings.warn(f"{error}; the indicator is omitted", IndicatorWarning, stacklevel=3)
    return names
