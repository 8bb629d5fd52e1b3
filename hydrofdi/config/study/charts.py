"""Control charts that are asked for: their options moved in place, and what they watch checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hydrofdi.config.study.online import ChartConfig
from hydrofdi.config.study.options import move_options
from hydrofdi.detectors.charts import chart_kind, chart_names
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.labels import label_mistake
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.yaml_source import Path, Source


def normalize_charts(source: Source, online: Any, path: Path, made: Mapping[str, Indicator[Any]]) -> None:
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
