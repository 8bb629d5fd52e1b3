"""Indicators, scores and charts of a study of detection."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, field_validator

from hydrofdi.config.study.study import ChartConfig, OnlineConfig
from hydrofdi.detectors.registry import chart_kind, chart_names
from hydrofdi.detectors.scores.configuration import ScoreConfig, move_options
from hydrofdi.evaluation.tail import ThresholdKind
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.indicators.selection import label_mistake
from hydrofdi.records import Channel
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.settings.yaml_source import Path, Source


class DetectionConfig(Section):
    """Requirements on detectors, and the detectors that are judged."""

    false_alarm_rate: Annotated[float, SI("1", above=0, most=0.5)] = 0.01
    """False-alarm rate for which thresholds are set on healthy fit records [-]."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Confidence of intervals and bounds [-]."""

    probability: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.9
    """Probability with which a leak should be found: 90 % gives q90 and, with the confidence, q90/95 [-]."""

    threshold: ThresholdKind = "quantile"
    """``quantile``: the rate on average over fit sets. ``tolerance``: at most the rate, with ``confidence``.
    ``tail``: a generalised Pareto model of the largest scores, for rates of 0.1 % and less."""

    indicators: list[str] = Field(default_factory=list)
    """Labels of the indicators to judge; by default all that are measured. If the file has no ``indicators``,
    these are also the ones measured, in any form that ``indicators`` accepts; ``all`` then means all cheap
    ones."""

    sensors: list[Channel] = Field(default_factory=list)
    """Channels of the machine, by symbol or name, such as ``[P1, P2, x, u]``; scores that need others are
    left out. By default every channel may be used."""

    scores: dict[str, ScoreConfig] = Field(default_factory=dict)
    """Label → score computed from several numbers, or one compensated number. A label has letters, digits,
    ``_`` and ``-``, begins with a letter, has at most 64 characters, and is not the label of an indicator."""

    usual_scores: bool = False
    """Whether to add, for each set of sensors that an indicator needs, a score of all numbers from these
    sensors: ``mahalanobis``, and ``lda`` if there are leaking fit records; also ``largest_change`` of
    ``dwt.d1`` … ``dwt.d5`` if they are measured."""

    online: OnlineConfig | None = None
    """Control charts on the traces of the records: false alarms over time, and the delay after the onset of a
    leak."""

    @field_validator("sensors")
    @classmethod
    def _each_once(cls, given: list[Channel]) -> list[Channel]:
        return list(dict.fromkeys(given))


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
