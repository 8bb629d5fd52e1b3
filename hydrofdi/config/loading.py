"""Experiment files and settings → a validated experiment, with all mistakes at once."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.experiment import DWT, INTERNAL_LEAKAGE_FORMS, STORED, ExperimentConfig, IndicatorChoice
from hydrofdi.config.normalizing import normalize
from hydrofdi.config.request import RunRequest, full_name, meant, parameter_names, parameter_unit
from hydrofdi.config.study import WatchedChart
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.detectors.rules import normalize_chart, normalize_scores
from hydrofdi.errors import ConfigError, Issue, StoreError
from hydrofdi.indicators.contract import Indicator, RecursiveIndicator
from hydrofdi.indicators.registry import label_mistake, load_plugins, sound_indicator
from hydrofdi.indicators.selection import chosen_options, make_chosen
from hydrofdi.settings.arguments import path_of
from hydrofdi.settings.files import Keys as Path
from hydrofdi.settings.files import (
    Source,
    located,
    merged,
    overlay,
    parse_yaml,
    plain,
    read_extended,
    validated,
    yaml_text,
)
from hydrofdi.settings.messages import brief, describe_error, nearest
from hydrofdi.transforms import WaveletConfig
from hydrofdi.units import parse_unit, stated_unit


def note_written_units(source: Source) -> None:
    """Add to ``units`` the first unit that each parameter is written with, unless SI or of a leakage flow."""
    if not isinstance(source.data, dict) or not isinstance(stated := source.data.get("units") or {}, dict):
        return
    units: dict[str, str] = {}
    for name, container, key in _written(source.data):
        own = parameter_unit(name)
        if own is not None and name not in INTERNAL_LEAKAGE_FORMS:
            unit = stated_unit(container[key].partition(":")[0], own)  # also of an axis first:last:count
            if unit and parse_unit(unit) != parse_unit(own):
                units.setdefault(name, unit)
    if units or stated:
        source.data["units"] = units | stated


def anchor_files(data: Any, folder: FilePath) -> None:
    """Make the paths of input files and plug-ins start from the folder of the file that names them."""
    for name, container, key in list(_written(data)):
        if name == "input.file" and "\n" not in container[key]:
            container[key] = str(located(FilePath(container[key]), folder))
    match data.get("plant"):
        case {"fmu": str(path)}:
            data["plant"]["fmu"] = str(located(FilePath(path), folder))
    match data.get("plugins"):
        case str(path):
            data["plugins"] = str(folder / path)
        case list(paths):
            data["plugins"] = [str(folder / path) if isinstance(path, str) else path for path in paths]


def _written(data: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Parameter, container and key of each text written for one: in sections, axes and distributions."""
    known = parameter_names()
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        here = name
        if isinstance(data, dict) and name not in known:
            here = key if key in known else f"{name.rpartition('.')[2]}.{key}"
        if isinstance(value, dict | list):
            yield from _written(value, here)
        elif isinstance(value, str) and here in known:
            yield here, data, key


_HAVE_PARAMETERS = ("baseline", "sweep", "ensemble", "study", "units")
"""Parts of a file that contain dotted parameters."""

PARAMETER_MAPPINGS = ("baseline", "grid", "zip", "over", "per_record")
_OF_PARAMETERS = (*PARAMETER_MAPPINGS, "faults", "units")
"""Mappings in them whose keys are dotted parameters; others are those of shifts and confusions."""


def use_full_names(source: Source) -> None:
    """Replace what names a parameter by its full name: at the top, in its section, and in mappings.

    Keys of ``sweep``, such as ``grid``, may stand at the top as well.
    """
    if isinstance(data := source.data, dict):
        for key in [key for key in data if key not in ExperimentConfig.model_fields]:
            full = f"sweep.{key}" if key in SweepConfig.model_fields else full_name(key)
            section, _, field = full.partition(".")
            is_known = full in parameter_names() or section == "sweep"
            if is_known and isinstance(data.setdefault(section, {}), dict):
                _move(source, (key,), data, (section, field), data[section])
        _use_full_names(source, data, ())


def _use_full_names(source: Source, data: Any, path: Path) -> None:
    is_inside = path[:1] and path[0] in _HAVE_PARAMETERS
    is_mapping = is_inside and path[-1] in _OF_PARAMETERS
    is_section = len(path) == 1 and path[0] in RunRequest.model_fields
    is_changed = is_inside and len(path) == 3 and path[1] in ("shifts", "confusions")
    if isinstance(data, dict) and (is_mapping or is_section or is_changed):
        for key in list(data):
            within = f"{path[0]}." if is_section else ""
            full = full_name(f"{within}{key}").removeprefix(within)
            _move(source, (*path, key), data, (*path, full), data)
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, dict | list):
            _use_full_names(source, value, (*path, key))


def _move(source: Source, old: Path, data: dict[Any, Any], new: Path, target: dict[Any, Any]) -> None:
    """Move a value to another key, behind those that are there."""
    value = data.pop(old[-1])
    if new[-1] in target:
        source.report(old, f"is another name of {'.'.join(map(str, new))}, which is given as well")
    target[new[-1]] = value
    if new != old:
        source.move(old, new)


_EXCLUSIVE = (("internal_coefficient", "internal_flow"), INTERNAL_LEAKAGE_FORMS)
"""Pairs of keys of which a later one replaces an earlier other."""


Experiment = str | PathLike[str] | Mapping[str, Any] | ExperimentConfig
"""A YAML file, what would stand in one, or an experiment that is loaded."""


def load_experiment(
    file: Experiment | None = None, settings: Sequence[str] | Mapping[str, Any] = ()
) -> ExperimentConfig:
    """The experiment that a YAML file and settings describe.

    Parameters
    ----------
    file : path, mapping or ExperimentConfig, optional
        YAML file, what would stand in one, or what is loaded; without it every parameter has its nominal
        value. It may extend other files (``extends: other.yaml``), whose keys it overrides.
    settings : sequence of str, or mapping
        ``"fluid.bulk_modulus=689 MPa"`` and the like, or ``{"fluid.bulk_modulus": "689 MPa"}``; they win
        over the file.

    Raises
    ------
    ConfigError
        With every mistake in the files and the settings.
    """
    if isinstance(file, ExperimentConfig):
        if settings:
            raise ConfigError("the experiment is already loaded; pass the settings to load_experiment")
        return file
    if isinstance(file, Mapping) and not file and settings:
        file = None
    source = _read(file)
    settings = [settings] if isinstance(settings, str) else settings
    if not isinstance(settings, Iterable) or not all(isinstance(setting, str) for setting in settings):
        expected = "{'fluid.bulk_modulus': '689 MPa'}, or texts such as 'fluid.bulk_modulus=689 MPa'"
        raise ConfigError(f"settings: expected {expected}; found {brief(settings)}")
    for setting in settings:
        if not isinstance(settings, Mapping):
            _apply_setting(source, setting)
        elif path := _setting_path(source, setting):
            _lay(source, path, plain(settings[setting]))
    keys = {setting.partition("=")[0].strip() for setting in settings}
    for section in ("", "baseline.", "sweep.grid.", "sweep.zip."):
        named = [full_name(key.removeprefix(section)) for key in keys if key.startswith(section)]
        if {*named} >= set(INTERNAL_LEAKAGE_FORMS):
            message = "give internal_coefficient or internal_flow, not both"
            source.mistakes.append(Issue(message, f"{section}leakage"))
        twice = (name for name, number in Counter(named).items() if number > 1 and name in parameter_names())
        source.mistakes += [Issue("is given twice, under two names", f"{section}{name}") for name in twice]
    _normalize_detection(source, load_plugins(source))
    normalize(source)
    return validated(ExperimentConfig, source)


def stored_experiment(text: str, place: str) -> ExperimentConfig:
    """Parse a resolved configuration, whose indicators need not be installed."""
    try:
        return ExperimentConfig.model_validate_json(text, context=STORED)
    except ValidationError as error:
        first = error.errors()[0]
        why = ": ".join(filter(None, (".".join(map(str, first["loc"])), describe_error(first))))
        raise StoreError(f"{place}: cannot be read: {why}") from None


def text_of_settings(settings: Sequence[str], extends: str) -> str:
    """The text of an experiment file with what settings say, on top of another one."""
    source = Source({})
    for text in settings:
        _apply_setting(source, text)
    if source.mistakes:
        raise ConfigError(source.mistakes)
    data = ({"extends": extends} if extends else {}) | source.data
    data.pop("units", None)  # written with the values
    first = {key: data.pop(key) for key in ("extends", "name") if key in data}
    return yaml_text(first | data)


def _read(file: str | PathLike[str] | Mapping[str, Any] | None) -> Source:
    kind = "an experiment file"
    if file is None:
        return Source({})
    if isinstance(file, Mapping):
        return read_extended(FilePath("the mapping"), kind, _prepare, _merged, own=Source(plain(file)))
    return read_extended(path_of(file), kind, _prepare, _merged)


def _prepare(own: Source, file: FilePath) -> None:
    """Prepare each file of an experiment before it extends others."""
    if not own.data:
        nothing = (
            "states nothing; write at least a name, such as 'name: nominal' for the actuator of the paper"
        )
        raise ConfigError([Issue(nothing, origin=str(file))])
    use_full_names(own)
    anchor_files(own.data, file.parent)
    note_written_units(own)


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Mappings are merged, but values of parameters are not."""
    return merged(base, over, parameter_names(), _EXCLUSIVE)


def _apply_setting(source: Source, text: str) -> None:
    key, equals, stated = text.partition("=")
    origin = f"settings {text}"
    if not equals or not key.strip():
        source.mistakes.append(Issue("expected KEY=VALUE, like fluid.bulk_modulus='689 MPa'", origin=origin))
        return
    if not stated.strip():
        source.mistakes.append(Issue("has no value after '='", key, origin))
        return
    value = parse_yaml(stated, origin)
    if value.mistakes:
        source.mistakes.extend(Issue(mistake.message, key.strip(), origin) for mistake in value.mistakes)
        return
    if not (path := _setting_path(source, key.strip(), origin)):
        return
    origins = dict.fromkeys([path, *((*path, *inner) for inner in value.origins)], origin)
    around = (path[:depth] for depth in range(1, len(path)))
    origins |= {part: origin for part in around if part not in source.origins}
    _lay(source, path, value.data, origins)


def _lay(source: Source, path: Path, value: Any, origins: dict[Path, str] | None = None) -> None:
    """Lay a value over a source; a value without an origin removes the origin in the file."""
    for part in reversed(path):
        value = {part: value}
    laid = Source(value, {path: ""} if origins is None else origins)
    use_full_names(laid)
    note_written_units(laid)
    overlay(source, laid, _merged)


def _setting_path(source: Source, key: str, origin: str = "") -> Path:
    """Where a setting stands in the file; empty, with a mistake, if its key is unknown or ambiguous."""
    known = [*ExperimentConfig.model_fields, *SweepConfig.model_fields]
    full = key if key in known else full_name(key)
    if "." not in full and full not in known:
        source.mistakes.append(Issue(f"unknown key{meant(key, known)}", key, origin))
        return ()
    parts = tuple(full.split("."))
    if "plant" in parts[:-2]:  # a parameter of an FMU, whose name may have dots
        index = parts.index("plant")
        named = ".".join(parts[index:])
        return (*parts[:index], named) if index else ("plant", named.partition(".")[2])
    is_below = parts[0] in _HAVE_PARAMETERS and len(parts) > 2 and parts[-2] not in _OF_PARAMETERS
    if is_below and (parts[-2] in RunRequest.model_fields or parts[-3] in _OF_PARAMETERS):
        return (*parts[:-2], ".".join(parts[-2:]))
    return parts


def _normalize_detection(source: Source, from_files: Mapping[str, str]) -> None:
    """``indicators`` (by default those of ``detection``) and ``detection`` with options of each label."""
    data, path = source.data, ("detection", "indicators")
    detection = data["detection"] if isinstance(data.get("detection"), dict) else {}
    if (stated := detection.get("indicators")) is not None:
        chosen = chosen_options(stated, source, path)
        is_all = isinstance(stated, str) and stated.strip() == "all"
        if "indicators" not in data:
            if is_all:
                chosen = {name: {} for name in chosen if sound_indicator(name).is_cheap}
            data["indicators"], is_all = chosen, False
            source.move(path, ("indicators",))
        detection["indicators"] = [] if is_all else list(chosen)
    is_valid = "indicators" not in data or _normalize_indicators(source, from_files)
    if not detection or not is_valid:
        return
    try:
        wavelet = WaveletConfig.model_validate(data.get("wavelet", {}))
    except ValidationError:  # a mistake when the model is validated
        return
    made = IndicatorChoice(json.dumps(data.get("indicators", {DWT: {}}))).made(wavelet)
    for index, label in enumerate(detection.get("indicators") or ()):
        if label not in made:
            message = f"{label!r} is not among the indicators{nearest(str(label), list(made))}"
            source.report((*path, index), message)
    normalize_scores(source, detection.get("scores"), ("detection", "scores"), made)
    online = detection.get("online")
    charts = online.get("charts") if isinstance(online, dict) else None
    for label, chart in charts.items() if isinstance(charts, dict) else ():
        here = ("detection", "online", "charts", label)
        if mistake := label_mistake(label, "a chart"):
            source.report(here, f"{label!r} {mistake}")
        if isinstance(chart, dict):
            _normalize_chart(source, chart, here, made)


def _normalize_indicators(source: Source, from_files: Mapping[str, str]) -> bool:
    """Whether the ``indicators`` are valid: then as ``label: {options}``, else left out."""
    own = Source(source.data, source.origins)
    chosen = chosen_options(source.data["indicators"], own, ("indicators",))
    for label, given in chosen.items():
        if isinstance(given, dict | None):
            named = {"kind": label} | (given or {})
            full = {key: from_files.get(str(named.get(key))) for key in ("kind", "of")}
            chosen[label] = (given or {}) | {key: name for key, name in full.items() if name}
    options = chosen.get(DWT)
    wavelet = _wavelet_with(own, options) if isinstance(options, dict) else {}
    try:
        make_chosen(chosen, own, ("indicators",))
    except ConfigError:
        source.mistakes.extend(own.mistakes)
        del source.data["indicators"]
        return False
    if options:
        source.data["wavelet"], chosen[DWT] = wavelet, {}
    source.data["indicators"] = {label: dict(options or {}) for label, options in chosen.items()}
    return True


def _wavelet_with(source: Source, options: dict[str, Any]) -> Any:
    """The section ``wavelet`` with the options of ``dwt``."""
    wavelet = source.data.get("wavelet") or {}
    for name, value in options.items():
        if name in ("channel", "kind"):
            message = f"the label {DWT} is the transform of P1; give it another label, with 'kind: {DWT}'"
            source.report(("indicators", DWT, name), message)
            continue
        if isinstance(wavelet, dict) and wavelet.get(name, value) != value:
            source.report(("indicators", DWT, name), f"wavelet.{name} says {wavelet[name]!r}; give it once")
        source.origins[("wavelet", name)] = source.origin(("indicators", DWT, name))
        wavelet = {**wavelet, name: value} if isinstance(wavelet, dict) else wavelet
    return wavelet


def _normalize_chart(
    source: Source, chart: dict[str, Any], path: Path, made: Mapping[str, Indicator[Any]]
) -> None:
    """Move the options of a chart under ``options``; check them and what is watched."""
    normalize_chart(source, chart, path, WatchedChart)
    if not isinstance(watched := chart.get("of"), str):
        return
    traced = {
        f"{label}.{indicator.estimates[0].name}": indicator
        for label, indicator in made.items()
        if isinstance(indicator, RecursiveIndicator)
    }
    if watched not in traced:
        source.report(
            (*path, "of"), f"no indicator keeps a trace of {watched!r}{nearest(watched, [*traced])}"
        )
    elif not traced[watched].n_instant:
        source.report((*path, "of"), f"no trace of {watched} is kept: give the indicator its trace_duration")
