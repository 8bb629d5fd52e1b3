"""Indicators, scores and charts of a study of detection."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from hydrofdi.config.study.study import ChartConfig, OnlineConfig, move_options
from hydrofdi.detectors.registry import chart_kind, chart_names, score_kind, score_names
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.indicators.selection import label_mistake
from hydrofdi.records import Channel
from hydrofdi.settings.extending import read_extended
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.settings.ready import located
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Path, Source


class ScoreConfig(Section):
    """A score computed from measured numbers."""

    kind: Literal["mahalanobis", "one_class", "lda", "logistic", "compensated", "largest_change"]
    """``mahalanobis`` and ``one_class`` are fitted to healthy fit records, ``lda`` and ``logistic`` to
    healthy and leaking ones. ``compensated``: a number minus its expected value, from its regression on
    ``by`` in healthy fit records. ``largest_change``: the largest fall below the mean of healthy fit records,
    as a share of it; of ``dwt.d1`` … ``dwt.d5`` the rule of the paper."""

    of: list[str] = Field(min_length=1)
    """Inputs: labels of indicators, or single numbers such as ``ring_down.damping_ratio``."""

    by: list[str] = Field(default_factory=list)
    """Numbers that ``compensated`` regresses on."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the kind, which may also be given next to the other keys: ``shrinkage`` (0 to 1) of
    ``mahalanobis``; ``outside`` (share of fit records, above 0) and ``width`` of ``one_class``; ``seed`` of
    ``logistic``."""

    @model_validator(mode="after")
    def _compensated_alone_regresses(self) -> Self:
        if (self.kind == "compensated") != bool(self.by):
            needs = "has no use for 'by'" if self.by else "needs 'by': numbers to regress on"
            raise ValueError(f"{self.kind} {needs}")
        return self


class ScoresConfig(Section):
    """The ``scores`` of a file of indicators."""

    scores: dict[str, ScoreConfig]


class DetectionConfig(Section):
    """Requirements on detectors, and the detectors that are judged."""

    false_alarm_rate: Annotated[float, SI("1", above=0, most=0.5)] = 0.01
    """False-alarm rate for which thresholds are set on healthy fit records [-]."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Confidence of intervals and bounds [-]."""

    probability: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.9
    """Probability with which a leak should be found: 90 % gives q90 and, with the confidence, q90/95 [-]."""

    threshold: Literal["quantile", "tolerance", "tail"] = "quantile"
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


_CHOICE_OF_ONE = re.compile(r"\[.*|\s*\(.*")
"""Behind the name of a number: its place in an array, or that its change is meant."""


def load_scores(indicators: str, made: Mapping[str, Indicator[Any]]) -> dict[str, ScoreConfig]:
    """The ``scores`` of a file of indicators; none where no file is named, or it has none.

    Parameters
    ----------
    indicators : str
        What `hydrofdi.indicators.load_indicators` took.
    made : mapping of str to Indicator
        What it gave.

    Raises
    ------
    ConfigError
        With every mistake.
    """
    if not located(FilePath(indicators)).is_file():
        return {}
    source = read_extended(FilePath(indicators), "a file of indicators")
    source.data = {"scores": source.data.get("scores") or {}}
    normalize_scores(source, source.data["scores"], ("scores",), made)
    return validated(ScoresConfig, source).scores


def normalize_scores(source: Source, scores: Any, path: Path, made: Mapping[str, Indicator[Any]]) -> None:
    """Move the options of scores under ``options``, and check labels, options and names of numbers."""
    numbers = [
        f"{label}.{output.name}" for label, each in made.items() for output in each.outputs if output.is_score
    ]
    for label, score in scores.items() if isinstance(scores, dict) else ():
        here = (*path, label)
        mistake = label_mistake(label, "a score") or ("is the label of an indicator" if label in made else "")
        if mistake:
            source.mistakes.append(source.mistake(here, f"{label!r} {mistake}"))
        if not isinstance(score, dict):
            continue
        _move_options(source, score, here)
        for kind in ("of", "by"):
            for place, name in enumerate(score[kind] if isinstance(score.get(kind), list) else ()):
                if _CHOICE_OF_ONE.sub("", str(name)) not in (*made, *numbers):
                    message = f"no indicator gives {name!r}{nearest(str(name), [*made, *numbers])}"
                    source.mistakes.append(source.mistake((*here, kind, place), message))


def _move_options(source: Source, score: dict[str, Any], path: Path) -> None:
    kind = score.get("kind")
    model = score_kind(kind).Options if kind in score_names() else Section
    move_options(source, score, path, ScoreConfig.model_fields, model)
