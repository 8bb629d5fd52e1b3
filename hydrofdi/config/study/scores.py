"""Scores that are asked for: their options moved in place, and checked where the file states them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from hydrofdi.config.study.detection import ScoreConfig, ScoresConfig
from hydrofdi.config.study.options import move_options
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.labels import label_mistake
from hydrofdi.scoring.registry import score_kind, score_names
from hydrofdi.settings.extending import read_extended
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.ready import located
from hydrofdi.settings.validation import validated
from hydrofdi.settings.yaml_source import Path, Source

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
