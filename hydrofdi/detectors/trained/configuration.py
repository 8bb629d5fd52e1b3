"""Configuration of a detector before training: indicator, windows, false-alarm rate; stated, and checked."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from hydrofdi.detectors.registry import chart_kind, make_chart, make_score, score_kind
from hydrofdi.detectors.scores.configuration import ScoreConfig, combined_numbers, normalize_score
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import ThresholdKind
from hydrofdi.indicators import Indicator, Output
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.records import Array
from hydrofdi.records.batch import Channel
from hydrofdi.records.streams import CycleWindower, TimeWindower, Windower
from hydrofdi.settings.messages import describe_error, listed, nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.settings.validation import overlay, read_extended, validated
from hydrofdi.settings.yaml_source import Path as KeyPath
from hydrofdi.settings.yaml_source import Source, dotted, plain

Duration = Annotated[float, SI("s", least=1e-9, most=1e9)]
Share = Annotated[float, SI("1", least=1e-9, most=0.5)]

_INDICATORS = "indicators"


class WindowConfig(Section):
    """Division of streams and long records into windows, which are judged one at a time."""

    by: Literal["time", "cycle", "estimate"] = "time"
    """``time``: windows of equal duration. ``cycle``: one window from each edge of the drive. ``estimate``: a
    recursive indicator follows the stream without windows, and each of its estimates is judged."""

    duration: Duration | None = None
    """Duration of a window [s]; by default that of the healthy records. Cycles are truncated to it; shorter
    ones are not judged."""

    every: Duration | None = None
    """Time between the starts of adjacent windows [s]; by default the duration. Windows overlap if it is
    shorter."""

    channel: Channel = Channel.INPUT_VOLTAGE
    """Channel whose edges start a cycle."""

    edge: Literal["rising", "falling", "both"] = "rising"
    """Edges that start a cycle. An edge is where the channel crosses the middle of its range in healthy
    records."""

    def n_every(self, n_sample: int, sampling_frequency: float) -> int:
        """Samples from the start of one window to the start of the next; cycles do not overlap."""
        if self.every is None or self.by == "cycle":
            return n_sample
        return max(1, round(self.every * sampling_frequency))

    def windower(
        self,
        n_sample: int,
        channels: Sequence[Channel],
        sampling_frequency: float,
        drive: tuple[float, float] | None,
    ) -> Windower:
        """The windower of a stream with these windows, not of estimates."""
        if self.by == "cycle":
            assert drive is not None
            return CycleWindower(n_sample, channels, sampling_frequency, self.channel, drive, self.edge)
        n_every = self.n_every(n_sample, sampling_frequency)
        return TimeWindower(n_sample, n_every, channels, sampling_frequency)


class ChartConfig(Section):
    """A control chart on the scores."""

    chart: str = "cusum"
    """Name of the chart: ``cusum`` (default), ``ewma``, ``glr`` or ``moving_window``."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the chart."""

    false_alarm_every: Duration = 86400.0
    """Mean time between false alarms of the chart, such as 30 days; a day by default [s]."""


class DetectorConfig(Section):
    """Configuration of a detector before training."""

    indicator: str = "dwt"
    """Name of an indicator."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the indicator."""

    output: str = ""
    """Output that is the score; by default the first one that is a score."""

    direction: Direction | None = None
    """Direction of change that raises an alarm; by default that of the output."""

    false_alarm_rate: Share = 0.01
    """Fraction of healthy windows that raise an alarm."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Confidence level of intervals."""

    threshold: ThresholdKind = "quantile"
    """``quantile``: meets the rate on average. ``tolerance``: meets it with the given confidence. ``tail``: a
    model of the largest scores, for rates of 0.1 % and less."""

    window: WindowConfig = WindowConfig()
    """Division of streams and long records into windows."""

    indicators: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Label → options of the indicators that ``score`` combines."""

    score: ScoreConfig | None = None
    """Score computed from several numbers; by default ``output`` is the score."""

    accept: bool = False
    """Whether to train although estimates are physically impossible in most healthy windows."""

    chart: ChartConfig | None = None
    """Control chart on the scores, whose alarms are those of the detector. By default one with a false alarm
    a day if the healthy records last a day or more; null: only the threshold is used."""


@dataclass(frozen=True)
class Number:
    """An output of an indicator that is a single number, or a place in one that is an array."""

    label: str
    output: Output
    place: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """Name, such as ``dwt.d2`` or ``dwt.d2_phases[3]``."""
        return f"{self.label}.{self.output.name}{''.join(f'[{part}]' for part in self.place)}"

    def found_in(self, values: Mapping[str, Array]) -> Array:
        """Its values among those of all outputs by ``label.output``, shape (n_record,)."""
        place: Any = (slice(None), *self.place)
        return np.asarray(values[f"{self.label}.{self.output.name}"][place])


@dataclass(frozen=True, eq=False)
class Feature:
    """What is judged: one number, or a score of several.

    Attributes
    ----------
    indicators : mapping of str to Indicator
        Label → indicator.
    numbers : tuple of Number
    score : ScoreConfig or None
    """

    indicators: Mapping[str, Indicator[Any]]
    numbers: tuple[Number, ...]
    score: ScoreConfig | None = None

    @property
    def indicator(self) -> Indicator[Any]:
        """The indicator of the first number."""
        return self.indicators[self.numbers[0].label]

    @property
    def described(self) -> Output:
        """The output that the first number is of."""
        return self.numbers[0].output

    @property
    def label(self) -> str:
        """Label, such as ``dwt.d2``."""
        return self.numbers[0].name if self.score is None else self.score.kind

    @property
    def meaning(self) -> str:
        """What the score is, in words."""
        return self.described.long_name if self.score is None else str(score_kind(self.score.kind).summary)

    @property
    def channels(self) -> frozenset[Channel]:
        """Channels that the indicators need."""
        return frozenset().union(*(each.channels for each in self.indicators.values()))

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """Channels that they use if they are there."""
        return frozenset().union(*(each.optional_channels for each in self.indicators.values()))

    @property
    def prefixed(self) -> Mapping[str, Indicator[Any]]:
        """Prefix of the names of outputs in doubts → indicator; that of a single number is empty."""
        if self.score is None:
            return {"": self.indicator}
        return {f"{label}.": each for label, each in self.indicators.items()}

    @property
    def outputs(self) -> Iterator[tuple[str, Output]]:
        """Name in doubts and output, for all outputs of the indicators."""
        for prefix, indicator in self.prefixed.items():
            yield from ((prefix + each.name, each) for each in indicator.outputs)

    def of(self, names: Collection[str]) -> Feature:
        """The same of some numbers alone."""
        numbers = tuple(each for each in self.numbers if each.name in names)
        labels = {each.label for each in numbers}
        indicators = {label: each for label, each in self.indicators.items() if label in labels}
        return Feature(indicators, numbers, self.score)


def feature_of(config: DetectorConfig) -> Feature:
    """What a detector judges.

    Raises
    ------
    ConfigError
        There is no such indicator or number, or there are several where there can be one.
    ValidationError
        The options of the indicator are not valid.
    """
    if config.score is not None:
        return _combination(config, config.score)
    indicator = sound_indicator(config.indicator, config.options)
    outputs = {each.name: each for each in indicator.outputs}
    name, _, place = config.output.partition("[")
    name = name or next(each.name for each in indicator.outputs if each.is_score)
    if name not in outputs:
        raise ConfigError(f"{indicator.name} has no output {name!r}{nearest(name, [*outputs])}")
    numbers = {each.name: each for each in _numbers(indicator.name, outputs[name])}
    full = f"{indicator.name}.{name}" + (f"[{place}" if place else "")
    if full not in numbers:
        raise ConfigError(f"{full} is an array, but a score is a single number{nearest(full, [*numbers])}")
    return Feature({indicator.name: indicator}, (numbers[full],))


def _numbers(label: str, output: Output) -> Iterator[Number]:
    for place in np.ndindex(tuple(output.dims.values())):
        yield Number(label, output, place)


def _combination(config: DetectorConfig, score: ScoreConfig) -> Feature:
    indicators = make_indicators(config.indicators)
    numbers = {
        number.name: number
        for label, each in indicators.items()
        for output in each.outputs
        if output.is_score
        for number in _numbers(label, output)
    }
    make_score(score.kind, score.options)
    if len(combined := combined_numbers(score, [*numbers], score.kind)) > 1:
        raise ConfigError(f"of: compensated is of one number here, not of {len(combined)}")
    chosen = tuple(numbers[name] for name in combined[0])
    return Feature(indicators, chosen, score).of({each.name for each in chosen})


def direction_of(config: DetectorConfig) -> Direction:
    """Direction of change by a leak: the chosen one, or that of the score.

    Raises
    ------
    ConfigError
        No direction is chosen, and that of the output depends on the actuator.
    """
    feature = feature_of(config)
    own = None if feature.score is None else score_kind(feature.score.kind).direction
    direction = config.direction or own or feature.described.direction
    if direction is None:
        raise ConfigError(
            f"choose the direction in which {feature.label} raises an alarm: rising, falling or both"
        )
    return direction


def unmakable(config: DetectorConfig) -> Iterator[tuple[KeyPath, str]]:
    """Key and message of each reason for which the detector's score or chart cannot be made."""
    faults: list[tuple[KeyPath, str]] = []
    key = "output"
    if config.score is None:
        faults += _unmakable("indicator", sound_indicator, indicator_kind, config.indicator, config.options)
    else:
        key, own = "score", config.score
        found = _unmakable("kind", make_score, score_kind, own.kind, own.options)
        faults += [((key, *path), text) for path, text in found]
    for place, make in ((key, feature_of), ("direction", direction_of)):
        try:
            if not faults:
                make(config)
        except (ConfigError, ValidationError) as fault:
            faults.append(((place,), str(fault)))
    yield from faults
    if config.chart is not None:
        for path, text in _unmakable(
            "chart", make_chart, chart_kind, config.chart.chart, config.chart.options
        ):
            yield ("chart", *path), text


def _unmakable(
    key: str, make: Callable[..., Any], kind: Callable[..., Any], name: str, options: Mapping[str, Any]
) -> Iterator[tuple[KeyPath, str]]:
    try:
        make(name, options)
    except ValidationError as errors:
        known = [*kind(name).Options.model_fields]
        for error in errors.errors():
            yield ("options", *error["loc"]), describe_error(error, known)
    except ConfigError as fault:
        yield (key,), str(fault)


def stated_detector(
    file: Path | Mapping[str, Any] | None, options: Mapping[KeyPath, tuple[str, Any]]
) -> DetectorConfig:
    """Read the configuration of a detector.

    Parameters
    ----------
    file : path or mapping, optional
        YAML file or equivalent mapping with the keys of `DetectorConfig`. It may extend other files, and may
        contain ``indicators:`` instead of ``indicator:`` and ``options:``; then ``indicator`` is one of their
        labels.
    options : mapping
        Key → keyword or option, and its value; these override the file.

    Raises
    ------
    ConfigError
        One or more mistakes; the error lists all of them.
    """
    kind = "a detector before it is trained"
    if file is None:
        source = Source({})
    elif isinstance(file, Mapping):
        source = read_extended(Path("the mapping"), kind, own=Source(plain(file)))
    else:
        source = read_extended(file, kind)
    given = Source({})
    for path, (option, value) in options.items():
        section = given.data
        for part in path[:-1]:
            section = section.setdefault(part, {})
        section[path[-1]] = value
        if option != dotted(path):
            given.origins[path] = option
    overlay(source, given)
    chosen = source.data.pop(_INDICATORS, None)
    if source.data.get("score") is not None:
        _combine(chosen, source)
    elif chosen is not None:
        _choose(chosen, source)
    config = validated(DetectorConfig, source)
    if mistakes := [source.mistake(path, text) for path, text in unmakable(config)]:
        raise ConfigError(mistakes)
    return config


def _combine(chosen: Any, source: Source) -> None:
    """State the indicators of a score by label, and the options of the score."""
    if chosen is None:
        chosen = {source.data.get("indicator", "dwt"): source.data.get("options")}
    elif source.data.get("indicator"):
        source.mistakes.append(source.mistake(("indicator",), "is one of 'indicators:' already; remove it"))
    made = make_indicators(chosen, source, (_INDICATORS,))
    normalize_score(source, source.data["score"], ("score",), made)
    if source.data.pop("output", None):
        message = "is for detectors without a score; the score combines the numbers under 'of'"
        source.mistakes.append(source.mistake(("output",), message))
    source.data |= {"indicator": "", "options": {}, _INDICATORS: stated_indicators(made)}


def stated_indicators(made: Mapping[str, Indicator[Any]], *, in_full: bool = False) -> dict[str, Any]:
    """Label → name and options of indicators, as users state them, or with all options."""
    return {
        label: {"kind": each.name} | each.options.model_dump(mode="json", exclude_unset=not in_full)
        for label, each in made.items()
    }


def _choose(chosen: Any, source: Source) -> None:
    """Replace ``indicators:`` by the chosen indicator."""
    made = make_indicators(chosen, source, (_INDICATORS,))
    label = source.data.get("indicator") or next(iter(made))
    if "options" in source.data:
        raise ConfigError([source.mistake(("options",), "belong under the label in 'indicators:'")])
    if label not in made or ("indicator" not in source.data and len(made) > 1):
        hint = nearest(str(label), [*made]) if label not in made else listed([*made])
        raise ConfigError([source.mistake((_INDICATORS,), f"choose an indicator{hint}")])
    source.data["indicator"] = made[label].name
    source.data["options"] = made[label].options.model_dump(exclude_unset=True)
