"""Scores and charts by their names and as users state them, and what is asked of detectors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from importlib import import_module
from typing import Annotated, Any, ClassVar, Literal, Self

from numpy.typing import ArrayLike
from pydantic import Field, ValidationError, model_validator

from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import THRESHOLDS, Threshold, ThresholdKind, records_needed
from hydrofdi.indicators.contract import Indicator
from hydrofdi.indicators.registry import label_mistake
from hydrofdi.indicators.selection import indicators_file
from hydrofdi.settings.files import Keys as Path
from hydrofdi.settings.files import Source, validated
from hydrofdi.settings.messages import describe_error, nearest
from hydrofdi.settings.quantities import SI, Section


class Method(Section):
    """A score or a chart. Its fields are its options, which all have defaults.

    Attributes
    ----------
    name : str
        Name in files and on the command line.
    summary : str
        What it computes, in one sentence.
    caution : str
        Limitations that users must know.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    caution: ClassVar[str]


class _Registry:
    """Classes of a module with a ``name``."""

    def __init__(self, module: str, noun: str) -> None:
        self._module, self._noun = module, noun

    @cached_property
    def _kinds(self) -> dict[str, Any]:
        """Name → class; the module is loaded when it is needed, as kernels take time to load."""
        module = import_module(f"hydrofdi.detectors.{self._module}")
        classes: list[Any] = [each for each in vars(module).values() if isinstance(each, type)]
        return {each.name: each for each in classes if "name" in vars(each)}

    def names(self) -> list[str]:
        """All names, sorted."""
        return sorted(self._kinds)

    def kind(self, name: str) -> Any:
        """The class of a name."""
        if name not in self._kinds:
            raise ConfigError(f"there is no {self._noun} {name!r}{nearest(name, self.names())}")
        return self._kinds[name]

    def make(self, name: str, options: Mapping[str, Any] | None = None) -> Any:
        """An instance with options."""
        return self.kind(name).model_validate(dict(options or {}))


_SCORES = _Registry("scores.catalogue", "score")
score_names, score_kind, make_score = _SCORES.names, _SCORES.kind, _SCORES.make

_CHARTS = _Registry("charts", "chart")
chart_names, chart_kind, make_chart = _CHARTS.names, _CHARTS.kind, _CHARTS.make


class ChartConfig(Section):
    """A control chart on scores: the rule."""

    chart: Literal["cusum", "ewma", "glr"] = "cusum"
    """The rule."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the rule, which may also be given next to the other keys."""


_Confident = Annotated[float, SI("1", least=0.5, most=0.9999)]


class Promise(Section):
    """The false-alarm rate of a threshold."""

    false_alarm_rate: Annotated[float, SI("1", least=1e-9, most=0.5)] = 0.01
    """Fraction of healthy records, or of windows of a detector, that raise an alarm [-]."""

    confidence: _Confident = 0.95
    """Confidence of intervals and bounds [-]."""

    threshold: ThresholdKind = "quantile"
    """``quantile``: meets the rate on average. ``tolerance``: meets it with ``confidence``. ``tail``: a
    generalised Pareto model of the largest scores, for rates of 0.1 % and less."""

    def set_threshold(self, healthy: ArrayLike, direction: Direction) -> Threshold:
        """Set a threshold from healthy fit scores, shape (n_record,)."""
        method = THRESHOLDS[self.threshold]
        return method(healthy, self.false_alarm_rate, direction=direction, confidence=self.confidence)


class Rules(Promise):
    """Requirements on the detectors of a study, and confidence levels."""

    probability: _Confident = 0.9
    """Probability with which a leak should be found: 90 % gives q90 and, with the confidence, q90/95 [-]."""

    def records_for_threshold(self, direction: Direction) -> int:
        """Number of healthy fit records that a threshold in this direction needs; 0 if one is enough."""
        try:
            self.set_threshold([0.0], direction)
        except NotStatedError as refusal:
            return refusal.records_needed or 0
        return 0

    @property
    def records_for_false_alarms(self) -> int:
        """Minimum number of records for a rate: without any alarm they demonstrate the false-alarm rate."""
        return records_needed(self.false_alarm_rate, self.confidence)

    @property
    def records_for_detection(self) -> int:
        """Number of records that demonstrate the probability if all are detected: 29 for 90/95."""
        return records_needed(1.0 - self.probability, self.confidence)


CHANGE = " (change)"
"""Suffix of the name of a number that is a change since an earlier record."""

_CHOICE_OF_ONE = re.compile(r"\[.*|\s*\(.*")
"""Behind the name of a number: its place in an array, or that its change is meant."""


class ScoreConfig(Section):
    """A score computed from measured numbers."""

    kind: Literal["mahalanobis", "one_class", "lda", "logistic", "compensated", "largest_change", "either"]
    """``mahalanobis`` and ``one_class`` are fitted to healthy fit records, ``lda`` and ``logistic`` to
    healthy and leaking ones. ``compensated``: a number minus its expected value, from its regression on
    ``by`` in healthy fit records. ``largest_change``: the largest fall below the mean of healthy fit records,
    as a share of it; of ``dwt.d1`` … ``dwt.d5`` the rule of the paper. ``either``: the number that is
    farthest above its healthy values, in the unit of the first."""

    of: list[str] = Field(min_length=1)
    """Inputs: labels of indicators, or single numbers such as ``ring_down.damping_ratio``."""

    by: list[str] = Field(default_factory=list)
    """Numbers that ``compensated`` regresses on."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the kind, which may also be given next to the other keys: ``shrinkage`` (0 to 1) of
    ``mahalanobis``; ``outside`` (share of fit records, above 0) and ``width`` of ``one_class``; ``seed`` of
    ``logistic``; ``proxies`` of ``either``: how many of its numbers, the last ones, are conditions that
    explain the others."""

    @model_validator(mode="after")
    def _compensated_alone_regresses(self) -> Self:
        if (self.kind == "compensated") != bool(self.by):
            needs = "has no use for 'by'" if self.by else "needs 'by': numbers to regress on"
            raise ValueError(f"{self.kind} {needs}")
        return self


OF_ONE = ("compensated", "either")
"""Kinds of scores with the unit of their first number."""


class ScoresConfig(Section):
    """The ``scores`` of a file of indicators."""

    scores: dict[str, ScoreConfig]


def load_scores(indicators: str, made: Mapping[str, Indicator[Any]]) -> dict[str, ScoreConfig]:
    """The ``scores`` of a file of indicators; none where no file is named, or it has none."""
    source = indicators_file(indicators)
    if source is None:
        return {}
    source.data = {"scores": source.data.get("scores") or {}}
    normalize_scores(source, source.data["scores"], ("scores",), made)
    return validated(ScoresConfig, source).scores


def normalize_scores(source: Source, scores: Any, path: Path, made: Mapping[str, Indicator[Any]]) -> None:
    """Move the options of scores under ``options``, and check labels, options and names of numbers."""
    for label, score in scores.items() if isinstance(scores, dict) else ():
        here = (*path, label)
        mistake = label_mistake(label, "a score") or ("is the label of an indicator" if label in made else "")
        if mistake:
            source.mistakes.append(source.mistake(here, f"{label!r} {mistake}"))
        normalize_score(source, score, here, made)


def normalize_score(source: Source, score: Any, path: Path, made: Mapping[str, Indicator[Any]]) -> None:
    """Move the options of a score under ``options``, and check these and the names of numbers."""
    if not isinstance(score, dict):
        return
    kind = score.get("kind")
    model = score_kind(kind) if kind in score_names() else Section
    move_options(source, score, path, ScoreConfig.model_fields, model)
    numbers = [
        f"{label}.{output.name}" for label, each in made.items() for output in each.outputs if output.is_score
    ]
    for key in ("of", "by"):
        for index, name in enumerate(score[key] if isinstance(score.get(key), list) else ()):
            if _CHOICE_OF_ONE.sub("", str(name)) not in (*made, *numbers):
                message = f"no indicator gives {name!r}{nearest(str(name), [*made, *numbers])}"
                source.mistakes.append(source.mistake((*path, key, index), message))


def normalize_chart(source: Source, chart: Any, path: Path, model: type[ChartConfig]) -> None:
    """Move the options of a chart under ``options``, and check them."""
    if isinstance(chart, dict) and (rule := chart.get("chart", "cusum")) in chart_names():
        move_options(source, chart, path, model.model_fields, chart_kind(rule))


def move_options(
    source: Source, section: dict[str, Any], path: Path, fields: Iterable[str], model: type[Section]
) -> None:
    """Move all but some fields of a section under ``options``; what the model refuses is a mistake."""
    known = list(fields)
    beside = {name: section.pop(name) for name in [name for name in section if name not in known]}
    within = section.get("options", {})
    if not isinstance(within, dict):
        return
    options = section["options"] = within | beside
    try:
        model.model_validate(options)
    except ValidationError as errors:
        names = [*known, *model.model_fields]
        for error in errors.errors():
            where = error["loc"] if error["loc"][0] in beside else ("options", *error["loc"])
            source.mistakes.append(source.mistake((*path, *where), describe_error(error, names)))


def belongs(number: str, name: str) -> bool:
    """Whether a name refers to a number; changes since an earlier record only if the name says so."""
    if number.endswith(CHANGE) != name.endswith(CHANGE):
        return False
    number, name = number.removesuffix(CHANGE), name.removesuffix(CHANGE)
    return number == name or number.startswith((f"{name}.", f"{name}["))


def combined_numbers(score: ScoreConfig, known: Sequence[str], label: str) -> list[list[str]]:
    """Names of the numbers of a score, in order, each once; for `compensated` once for each `of`."""
    combined: list[dict[str, None]] = []
    for names in (score.of, score.by):
        own: dict[str, None] = {}
        for name in names:
            meant = [each for each in known if belongs(each, name)]
            if not meant:
                raise ConfigError(f"the score {label!r}: {name!r} is not measured{nearest(name, known)}")
            own |= dict.fromkeys(meant)
        combined.append(own)
    of, by = combined
    if score.kind != "compensated":
        return [[*of, *by]]
    return [[each, *(proxy for proxy in by if proxy != each)] for each in of]
