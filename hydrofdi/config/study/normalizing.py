"""The ``study`` and ``detection`` of a source in SI, with what follows from them spelled out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.experiment import DWT, INTERNAL_LEAKAGE_FORMS, IndicatorChoice
from hydrofdi.config.study.study import ChartConfig
from hydrofdi.config.study.table import changed_value
from hydrofdi.config.sweeps.distributions import distribution_in_si
from hydrofdi.config.sweeps.dotted_values import axis_in_si
from hydrofdi.config.sweeps.values import convert_mapping, is_stated, nominal_value
from hydrofdi.detectors.registry import chart_kind, chart_names
from hydrofdi.detectors.scores.configuration import move_options, normalize_scores
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.indicators.selection import chosen_options, label_mistake
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.yaml_source import Path, Source
from hydrofdi.transforms.configuration import WaveletConfig

STUDY: Path = ("study",)
_SEEDS = [0, 2**31 - 1]


def normalize_study(source: Source) -> None:
    """The ``study`` of a source in SI, with what is drawn and kept unless the file says otherwise.

    ``indicators`` and ``sweep`` have to be normalized before.
    """
    study = source.data.get("study")
    if study is None:
        source.data.pop("study", None)
    if not isinstance(study, dict):
        return
    if source.data.get("claims"):
        source.report(("claims",), "a study has no claims; those of the paper are about its own experiment")
    _leave_out_nothing(study)
    _normalize_faults(source, study.get("faults"))
    for kind in ("shifts", "confusions"):
        if isinstance(named := study.get(kind), dict):
            for name, changes in named.items():
                named[name] = _changes(source, (*STUDY, kind, name), changes)
    population = study.setdefault("population", {})
    if isinstance(population, dict):
        _leave_out_nothing(population)
        for kind in ("over", "per_record"):
            population.setdefault(kind, {})
            convert_mapping(source, population, kind, (*STUDY, "population"), distribution_in_si)
        _draw_per_record(source, population)
    _prefer(source, "calibration", "at", "nominal")
    _prefer(source, "store", "signals", "none")


def normalize_detection(source: Source) -> None:
    """``detection.indicators`` as labels; where the source has no ``indicators``, they become these."""
    detection = source.data.get("detection")
    if not isinstance(detection, dict) or detection.get("indicators") is None:
        return
    given, path = detection["indicators"], ("detection", "indicators")
    chosen = chosen_options(given, source, path)
    is_all = isinstance(given, str) and given.strip() == "all"
    if "indicators" in source.data:
        detection["indicators"] = [] if is_all else list(chosen)
        return
    if is_all:
        chosen = {name: {} for name in chosen if sound_indicator(name).is_cheap}
    source.data["indicators"] = chosen
    for place in [place for place in source.origins if place[:2] == path]:
        source.origins[("indicators", *place[2:])] = source.origins[place]
    detection["indicators"] = list(chosen)


def check_detection(source: Source) -> None:
    """Check that scores are made of numbers that are measured, charts watch traces, and labels are known.

    ``indicators`` has to be normalized before.
    """
    detection, path = source.data.get("detection"), ("detection",)
    if not isinstance(detection, dict):
        return
    try:
        wavelet = WaveletConfig.model_validate(source.data.get("wavelet", {}))
    except ValidationError:  # a mistake when the model is validated
        return
    made = IndicatorChoice.of(source.data.get("indicators", {DWT: {}})).made(wavelet)
    for place, label in enumerate(_listed(detection.get("indicators"))):
        if label not in made:
            message = f"{label!r} is not among the indicators{nearest(str(label), list(made))}"
            source.report((*path, "indicators", place), message)
    normalize_scores(source, detection.get("scores"), (*path, "scores"), made)
    _normalize_charts(source, detection.get("online"), (*path, "online"), made)


def _listed(given: Any) -> list[Any]:
    return given if isinstance(given, list) else []


def _normalize_faults(source: Source, faults: Any) -> None:
    """Faults with their axis under ``over``, also where it stands beside the counts."""
    if not isinstance(faults, dict):
        return
    path = (*STUDY, "faults")
    over = faults.setdefault("over", {})
    for name in [name for name in faults if "." in str(name)]:
        if isinstance(over, dict):
            over[name] = faults.pop(name)
            for place in [place for place in source.origins if place[:3] == (*path, name)]:
                source.origins[(*path, "over", *place[2:])] = source.origins[place]
    if not over:
        del faults["over"]
        wanted = " or ".join(reversed(INTERNAL_LEAKAGE_FORMS))
        source.report(path, f"names no leak: give {wanted}")
        faults["over"] = {INTERNAL_LEAKAGE_FORMS[1]: []}
    elif isinstance(over, dict):
        if len(over) > 1:
            message = f"the levels are those of one leak; give {' or '.join(map(str, over))}, not both"
            source.report(path, message)
            faults["over"] = over = dict([next(iter(over.items()))])
        for name in over:
            over[name] = _levels(source, (*path, "over", name), name, over[name])


def _leave_out_nothing(section: dict[str, Any]) -> None:
    """Leave out the parts of a section that are null: what was inherited from another file is gone."""
    for name in [name for name, part in section.items() if part is None]:
        del section[name]


def _levels(source: Source, path: Path, name: str, stated: Any) -> list[float]:
    """The levels that are numbers; each of the others is a mistake of the source."""
    levels = axis_in_si(source, path, name, stated)
    for place, level in enumerate(levels):
        if level is None:
            source.report((*path, place), "a level is a number with a unit, not null")
    return [level for level in levels if isinstance(level, float)]


def _changes(source: Source, path: Path, changes: Any) -> Any:
    """Values and distributions of parameters, in SI."""
    if not isinstance(changes, dict) or not changes:
        message = f"expected 'parameter: value' or 'parameter: {{distribution}}' pairs; found {changes!r}"
        source.report(path, message)
        return {}
    return {
        name: distribution_in_si(source, (*path, name), name, value)
        if isinstance(value, Mapping)
        else changed_value(source, (*path, name), name, value)
        for name, value in changes.items()
    }


def _draw_per_record(source: Source, population: dict[str, Any]) -> None:
    """Draw what differs from record to record, unless the source names it."""
    drawn = population["per_record"] if isinstance(population["per_record"], dict) else {}
    over = population["over"] if isinstance(population["over"], dict) else {}
    usual: dict[str, list[int]] = {"measurement.seed": _SEEDS}
    if DWT in source.data.get("indicators", {DWT: {}}):
        levels = nominal_value(source, "wavelet.levels")
        usual["wavelet.phase"] = [0, 2**levels - 1] if isinstance(levels, int) else [0, 0]
    if nominal_value(source, "input.shape") == "steps":
        usual["input.seed"] = _SEEDS
    if nominal_value(source, "load.random_force"):
        usual["load.seed"] = _SEEDS
    swept = set(_keys(source.data.get("sweep")))
    for name, ends in usual.items():
        is_named = is_stated(source, name) and name != "measurement.seed"
        if not (is_named or name in drawn or name in over or name in swept):
            drawn[name] = {"integers": ends}
    population["per_record"] = drawn


def _keys(data: Any) -> Iterator[str]:
    """Keys of mappings, and of those within."""
    for key in data if isinstance(data, dict) else ():
        yield from (key, *_keys(data[key]))
    for part in data if isinstance(data, list) else ():
        yield from _keys(part)


def _prefer(source: Source, section: str, field: str, value: Any) -> None:
    """Give a field a value where the source states none."""
    given = source.data.setdefault(section, {})
    if isinstance(given, dict):
        given.setdefault(field, value)


def _normalize_charts(source: Source, online: Any, path: Path, made: Mapping[str, Indicator[Any]]) -> None:
    """Move the options of charts under ``options``; check labels, rules, options and what is watched."""
    charts = online.get("charts") if isinstance(online, dict) else None
    for label, chart in charts.items() if isinstance(charts, dict) else ():
        here = (*path, "charts", label)
        if mistake := label_mistake(label, "a chart"):
            source.mistakes.append(source.mistake(here, f"{label!r} {mistake}"))
        if not isinstance(chart, dict):
            continue
        rule = chart.get("chart")
        if isinstance(rule, str) and rule not in chart_names():
            message = f"there is no chart {rule!r}{nearest(rule, chart_names())}"
            source.mistakes.append(source.mistake((*here, "chart"), message))
        model = chart_kind(rule).Options if rule in chart_names() else Section
        if rule in chart_names() or not isinstance(rule, str):
            move_options(source, chart, here, ChartConfig.model_fields, model)
        watched = chart.get("of")
        if isinstance(watched, str) and (message := _why_not_watched(watched, made)):
            source.mistakes.append(source.mistake((*here, "of"), message))


def _why_not_watched(watched: str, made: Mapping[str, Indicator[Any]]) -> str:
    """The reason why a number has no trace; empty if it has one."""
    traced = {
        f"{label}.{each.estimates[0].name}": each
        for label, each in made.items()
        if isinstance(each, RecursiveIndicator)
    }
    if watched not in traced:
        known = "" if traced else ": no indicator of this file follows records sample by sample"
        return f"no indicator keeps a trace of {watched!r}{known or nearest(watched, list(traced))}"
    if not traced[watched].n_instant:
        label = watched.partition(".")[0]
        return f"no trace of {watched} is kept: give {label} its trace_duration, such as that of the records"
    return ""
