"""Configuration of a detector before training: indicator, windows, false-alarm rate; stated, and checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from hydrofdi.detectors.registry import chart_kind, make_chart
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators import Indicator, Output
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import CycleWindower, TimeWindower, Windower
from hydrofdi.settings.extending import extended, overlay, read_extended
from hydrofdi.settings.messages import describe_error, listed, nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.settings.validation import validated
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

    chart: str
    """Name of the chart, such as ``cusum`` or ``ewma``."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the chart."""

    false_alarm_every: Duration = 86400.0
    """Required mean time between false alarms [s]."""


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

    threshold: Literal["quantile", "tolerance"] = "quantile"
    """``quantile``: meets the rate on average. ``tolerance``: meets it with the given confidence."""

    window: WindowConfig = WindowConfig()
    """Division of streams and long records into windows."""

    accept: bool = False
    """Whether to train although estimates are physically impossible in most healthy windows."""

    chart: ChartConfig | None = None
    """Control chart on the scores; by default only the threshold is used."""


@dataclass(frozen=True, eq=False)
class Feature:
    """The output of an indicator that is the score."""

    indicator: Indicator[Any]
    described: Output

    @property
    def label(self) -> str:
        """Label, such as ``dwt.d2``."""
        return f"{self.indicator.name}.{self.described.name}"


def feature_of(config: DetectorConfig) -> Feature:
    """Output that is the score.

    Raises
    ------
    ConfigError
        There is no such indicator or output, or the output is not a single number.
    ValidationError
        The options of the indicator are not valid.
    """
    indicator = sound_indicator(config.indicator, config.options)
    outputs = {each.name: each for each in indicator.outputs}
    name = config.output or next(each.name for each in indicator.outputs if each.is_score)
    if name not in outputs:
        raise ConfigError(f"{indicator.name} has no output {name!r}{nearest(name, [*outputs])}")
    if outputs[name].dims:
        raise ConfigError(f"{indicator.name}.{name} is an array, but a score is a single number")
    return Feature(indicator, outputs[name])


def direction_of(config: DetectorConfig) -> Direction:
    """Direction of change by a leak: the chosen one, or that of the output.

    Raises
    ------
    ConfigError
        No direction is chosen, and that of the output depends on the actuator.
    """
    feature = feature_of(config)
    direction = config.direction or feature.described.direction
    if direction is None:
        raise ConfigError(
            f"choose the direction in which {feature.label} raises an alarm: rising, falling or both"
        )
    return direction


def unmakable(config: DetectorConfig) -> Iterator[tuple[KeyPath, str]]:
    """Key and message of each reason for which the detector's score or chart cannot be made."""
    faults = [*_unmakable("indicator", sound_indicator, indicator_kind, config.indicator, config.options)]
    for key, made in (("output", feature_of), ("direction", direction_of)):
        try:
            if not faults:
                made(config)
        except ConfigError as fault:
            faults.append(((key,), str(fault)))
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
        source = extended(Source(plain(file)), Path("the mapping"), kind)
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
    if chosen is not None:
        _choose(chosen, source)
    config = validated(DetectorConfig, source)
    if mistakes := [source.mistake(path, text) for path, text in unmakable(config)]:
        raise ConfigError(mistakes)
    return config


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
