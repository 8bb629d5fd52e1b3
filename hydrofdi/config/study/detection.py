"""The ``indicators`` and the ``detection`` of a source, as labels with options."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from hydrofdi.config.experiment import DWT, IndicatorChoice
from hydrofdi.config.study.study import WatchedChart
from hydrofdi.detectors.scores.configuration import normalize_chart, normalize_scores
from hydrofdi.errors import ConfigError
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.indicators.selection import chosen_options, label_mistake, make_chosen
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.yaml_source import Path, Source
from hydrofdi.transforms.configuration import WaveletConfig


def normalize_detection(source: Source) -> None:
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
    is_valid = "indicators" not in data or _normalize_indicators(source)
    if not detection or not is_valid:
        return
    try:
        wavelet = WaveletConfig.model_validate(data.get("wavelet", {}))
    except ValidationError:  # a mistake when the model is validated
        return
    made = IndicatorChoice(json.dumps(data.get("indicators", {DWT: {}}))).made(wavelet)
    for place, label in enumerate(detection.get("indicators") or ()):
        if label not in made:
            message = f"{label!r} is not among the indicators{nearest(str(label), list(made))}"
            source.report((*path, place), message)
    normalize_scores(source, detection.get("scores"), ("detection", "scores"), made)
    online = detection.get("online")
    charts = online.get("charts") if isinstance(online, dict) else None
    for label, chart in charts.items() if isinstance(charts, dict) else ():
        here = ("detection", "online", "charts", label)
        if mistake := label_mistake(label, "a chart"):
            source.report(here, f"{label!r} {mistake}")
        if isinstance(chart, dict):
            _normalize_chart(source, chart, here, made)


def _normalize_indicators(source: Source) -> bool:
    """Whether the ``indicators`` are valid: then as ``label: {options}``, else left out."""
    own = Source(source.data, source.origins)
    chosen = chosen_options(source.data["indicators"], own, ("indicators",))
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
        f"{label}.{each.estimates[0].name}": each
        for label, each in made.items()
        if isinstance(each, RecursiveIndicator)
    }
    if watched not in traced:
        source.report(
            (*path, "of"), f"no indicator keeps a trace of {watched!r}{nearest(watched, [*traced])}"
        )
    elif not traced[watched].n_instant:
        source.report((*path, "of"), f"no trace of {watched} is kept: give the indicator its trace_duration")
