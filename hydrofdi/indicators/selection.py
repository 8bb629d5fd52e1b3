"""Selection of indicators and their options, in any form that users give, and their list."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.nominal_actuator import assumption_text, constants_not_given, from_sheet
from hydrofdi.indicators.registry import indicator_kind, indicator_names, label_mistake, sound_indicator
from hydrofdi.records import RecordSource
from hydrofdi.settings.files import Keys as KeyPath
from hydrofdi.settings.files import Source, located, plain, read_extended
from hydrofdi.settings.messages import describe_error, nearest


def chosen_options(chosen: Any, source: Source, within: KeyPath = ()) -> dict[str, Any]:
    """Label → options, for any form of choice; mistakes are collected in `source`."""
    if isinstance(chosen, str) and chosen.strip() == "all":
        return {name: {} for name in indicator_names()}
    given = [name.strip() for name in chosen.split(",")] if isinstance(chosen, str) else chosen
    is_unnamed = isinstance(chosen, str) and "" in given
    if not isinstance(given, Mapping | Sequence) or not given or is_unnamed:
        listed = "'hydrofdi indicators' lists them"
        message = f"expected 'all', names, or 'name: {{options}}' pairs; found {chosen!r}; {listed}"
        source.report(within, message)
        return {}
    if not isinstance(given, Mapping):
        return _named(given, source, within)
    for label in given:
        if mistake := label_mistake(label):
            source.report((*within, label), f"{label!r} {mistake}")
    return {str(label): options for label, options in given.items() if label_mistake(label) is None}


def _named(given: Sequence[Any], source: Source, within: KeyPath) -> dict[str, Any]:
    names: dict[str, Any] = {}
    for index, item in enumerate(given):
        name = item.strip() if isinstance(item, str) else item
        if isinstance(name, str) and name not in ("", "all", *names):
            names[name] = {}
        else:
            form = "'indicators: {dwt: {}, mine: {kind: dwt, levels: 3}}'"
            message = f"a list contains names, each once, not {name!r}; with options or labels, write {form}"
            source.report((*within, index), message)
    return names


_KIND_HINT = "; under a label of your own, add 'kind: NAME'"


_KEYS = ("indicators", "scores", "detection")
"""Keys of a file of indicators; the last one is for the experiments that extend it."""


def indicators_file(text: str) -> Source | None:
    """The content of a file of indicators; None where names are given instead."""
    if not text.endswith((".yaml", ".yml")) and not located(Path(text)).is_file():
        return None
    source = read_extended(Path(text), "a file of indicators")
    if "indicators" not in source.data:
        raise ConfigError([Issue("has no 'indicators:'", origin=text)])
    unknown = [key for key in source.data if key not in _KEYS]
    if unknown:
        raise ConfigError([source.mistake((key,), f"unknown key{nearest(key, _KEYS)}") for key in unknown])
    return source


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
    """Make indicators: label → indicator."""
    made = {label: _make(label, given, source, (*within, label)) for label, given in options.items()}
    if source.mistakes:
        raise ConfigError(source.mistakes)
    return {label: indicator for label, indicator in made.items() if indicator is not None}


def _with_data_sheet(
    indicators: Mapping[str, Indicator[Any]], sheet: Mapping[str, Any]
) -> dict[str, Indicator[Any]]:
    """Indicators that take what their options leave out of the plant from a data sheet."""
    options = {
        label: {"kind": each.name, **each.options.model_dump(exclude_unset=True)}
        | from_sheet(each.options, sheet)
        for label, each in indicators.items()
    }
    return make_chosen(options, Source(options))


def of_machine(
    indicators: Mapping[str, Indicator[Any]], sources: Sequence[RecordSource]
) -> dict[str, Indicator[Any]]:
    """Indicators that take what their options leave out from the data sheet of the records.

    Raises
    ------
    ConfigError
        The data sheets of the sources differ in what an indicator takes from them, or it refuses a value.
    """
    made, *others = (_with_data_sheet(indicators, source.data_sheet) for source in sources)
    for source, other in zip(sources[1:], others, strict=True):
        for label in made:
            if other[label].options.stated_text != made[label].options.stated_text:
                raise ConfigError(
                    f"{label}: {sources[0].name} and {source.name} describe different machines: state the"
                    " same 'actuator:' for both, or take them separately"
                )
    return made


def assumed_plants(indicators: Mapping[str, Indicator[Any]]) -> tuple[str, ...]:
    """A sentence for each set of indicators that assume the same constants, which are not given."""
    labels: dict[tuple[str, ...], list[str]] = {}
    for label, indicator in indicators.items():
        if names := constants_not_given(indicator.options):
            labels.setdefault(names, []).append(label)
    return tuple(assumption_text(", ".join(of), names) for names, of in labels.items())


def _make(label: str, given: Any, source: Source, path: KeyPath) -> Indicator[Any] | None:
    options = {} if given is None else given
    if not isinstance(options, Mapping):
        source.report(path, f"expected 'option: value' pairs; found {options!r}")
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


Indicators = str | PathLike[str] | Sequence[str] | Mapping[str, Any]
"""``"dwt,ring_down"``, ``"all"``, a list of names, a YAML file, or label → options."""


def indicators_of(given: Indicators) -> dict[str, Any]:
    """Label → indicator; a file may extend others, or be a ready one.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    if isinstance(given, int | float):
        raise ConfigError(f"indicators: found {given!r}; is it meant as sampling_frequency={given!r}?")
    if not isinstance(given, str | PathLike):
        return make_indicators(plain(given))
    source = indicators_file(fspath(given))
    if source is None:
        return make_indicators(fspath(given))
    return make_indicators(source.data["indicators"], source, ("indicators",))
