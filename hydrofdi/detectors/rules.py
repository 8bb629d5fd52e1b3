"""Scores and charts, found by their names, and what is asked of detectors, before training and in studies."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import Annotated, Any, ClassVar, Generic, Literal, TypeVar

from numpy.typing import ArrayLike
from pydantic import Field

from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import THRESHOLDS, Threshold, ThresholdKind, records_needed
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section

Chosen = TypeVar("Chosen", bound=Section)


class Method(Generic[Chosen]):
    """A score or a chart.

    Attributes
    ----------
    name : str
        Name in files and on the command line.
    summary : str
        What it computes, in one sentence.
    caution : str
        Limitations that users must know.
    Options : type of Section
        Model of its options; all of them have defaults.
    options : Section
        Options of this instance.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    caution: ClassVar[str]
    Options: ClassVar[type[Section]] = Section
    options: Chosen

    def __init__(self, options: Chosen | None = None) -> None:
        chosen: Any = self.Options() if options is None else options
        self.options = chosen


class _Registry:
    """Classes of a module with a ``name`` and ``Options``."""

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
        kind = self.kind(name)
        return kind(kind.Options.model_validate(dict(options or {})))


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
