"""Configuration of a detector before training: indicator, windows, false-alarm rate; stated, and checked."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from hydrofdi.detectors import rules
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators import Indicator, Output
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.indicators.selection import Indicators, make_indicators
from hydrofdi.records import Array, Channel
from hydrofdi.records.streams import CycleWindower, TimeWindower, Windower
from hydrofdi.settings.files import Keys as KeyPath
from hydrofdi.settings.files import Source, dotted, overlay, plain, read_extended, validated
from hydrofdi.settings.messages import describe_error, listed, nearest
from hydrofdi.settings.quantities import SI, Section

Duration = Annotated[float, SI("s", least=1e-9, most=1e9)]

_INDICATORS = "indicators"


class WindowConfig(Section):
    """Division of streams and long records into windows, which are judged one at a time."""

    by: Literal["time", "cycle"] = "time"
    """``time``: windows of equal duration. ``cycle``: one window from each edge of the drive."""

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
        """The windower of a stream with these windows."""
        if self.by == "cycle":
            assert drive is not None
            return CycleWindower(n_sample, channels, sampling_frequency, self.channel, drive, self.edge)
        n_every = self.n_every(n_sample, sampling_frequency)
        return TimeWindower(n_sample, n_every, channels, sampling_frequency)


class TimedChart(rules.ChartConfig):
    """A control chart on the scores of a detector."""

    false_alarm_every: Duration = 86400.0
    """Mean time between false alarms of the chart, such as 30 days; a day by default [s]."""


class DetectorConfig(rules.Promise):
    """Configuration of a detector before training."""

    indicator: str = "dwt"
    """Name of an indicator."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the indicator."""

    output: str = ""
    """Output that is the score; by default both flows of a balance, else the first one that is a score."""

    direction: Direction | None = None
    """Direction of change that raises an alarm; by default that of the output."""

    window: WindowConfig = WindowConfig()
    """Division of streams and long records into windows."""

    indicators: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Label → options of the indicators that ``score`` combines."""

    score: rules.ScoreConfig | None = None
    """Score computed from several numbers; by default ``output`` is the score."""

    compensate: bool = True
    """Whether to take the effect of the oil temperature out of ``output`` if the records have it: the score
    is then ``compensated`` by its mean in each window. If measured records lack it, the upper limit of a flow
    is raised by what oil that is 15 K warmer adds to a healthy one."""

    accept: bool = False
    """Whether to train although estimates are physically impossible in most healthy windows."""

    chart: TimedChart | None = None
    """Control chart on the scores, whose alarms are those of the detector. By default one with a false alarm
    a day if the healthy records last a day or more; null: only the threshold is used."""


@dataclass(frozen=True, eq=False)
class Feature:
    """What is judged: one number, or a score of several.

    Attributes
    ----------
    indicators : mapping of str to Indicator
        Label → indicator.
    numbers : mapping of str to (str, Output, tuple of int)
        Name, such as ``dwt.d2`` or ``dwt.d2_phases[3]`` → label of the indicator, its output, and the place
        in it if that is an array.
    """

    indicators: Mapping[str, Indicator[Any]]
    numbers: Mapping[str, tuple[str, Output, tuple[int, ...]]]
    score: rules.ScoreConfig | None = None

    @property
    def indicator(self) -> Indicator[Any]:
        """The first indicator."""
        return next(iter(self.indicators.values()))

    @property
    def described(self) -> Output:
        """The output that the first number is of."""
        return next(iter(self.numbers.values()))[1]

    @property
    def judged(self) -> list[str]:
        """The numbers that each have a limit of their own; none if the score combines them to another one."""
        if self.score is None:
            return [*self.numbers][:1]
        n_judged = len(self.numbers) - int(self.score.options.get("proxies", 0))
        return [*self.numbers][:n_judged] if self.score.kind == "either" else []

    @property
    def label(self) -> str:
        """Label, such as ``dwt.d2`` or ``weak_rls.leakage or cross_port_leakage``."""
        first, *others = self.judged or [str(self.score and self.score.kind)]
        return " or ".join([first, *(each.partition(".")[2] for each in others)])

    @property
    def meaning(self) -> str:
        """What the score is, in words."""
        if self.judged:
            return self.described.long_name if len(self.judged) == 1 else "each with its own limit"
        return str(self.score and rules.score_kind(self.score.kind).summary)

    @property
    def channels(self) -> frozenset[Channel]:
        """Channels that the indicators need."""
        return frozenset().union(*(each.channels for each in self.indicators.values()))

    @property
    def outputs(self) -> Mapping[str, Output]:
        """Name in doubts, such as ``weak_rls.leakage`` → output of an indicator."""
        pairs = self.indicators.items()
        return {f"{label}.{output.name}": output for label, each in pairs for output in each.outputs}

    @property
    def through_all(self) -> str:
        """Number that is the flow through all clearances, of which that of a leak takes up a share."""
        return f"{next(iter(self.indicators))}.{self.described.clearances[0]}"

    @property
    def leak(self) -> tuple[str, str] | None:
        """Outputs with the mean flow of a leak of any law, and its deviation; None if there are none."""
        names = (name for name, each in self.outputs.items() if each.name == "mean_leakage")
        return next(((name, f"{name}_error") for name in names), None)

    def values(self, measured: Mapping[str, Array]) -> Array:
        """The numbers among the values of all outputs, shape (n_record, n_number)."""
        everything: Any = slice(None)
        own = [
            measured[f"{label}.{output.name}"][(everything, *index)]
            for label, output, index in self.numbers.values()
        ]
        return np.stack(own, axis=1)

    def of(self, names: Collection[str]) -> Feature:
        """The same of some numbers alone."""
        numbers = {name: each for name, each in self.numbers.items() if name in names}
        labels = {label for label, *_ in numbers.values()}
        indicators = {label: each for label, each in self.indicators.items() if label in labels}
        return Feature(indicators, numbers, self.score)


def feature_of(config: DetectorConfig) -> Feature:
    """What a detector judges."""
    if config.score is None:
        indicator = sound_indicator(config.indicator, config.options)
        first = next(each.name for each in indicator.outputs if each.is_score)
        name = f"{indicator.name}.{config.output or first}"
        numbers = _numbers({indicator.name: indicator}, only_scores=False)
        if name not in numbers:
            is_array = any(each.startswith(f"{name}[") for each in numbers)
            what = "is an array, but a score is a single number" if is_array else "is no output"
            raise ConfigError(f"{name} {what}{nearest(name, [*numbers])}")
        return Feature({indicator.name: indicator}, {name: numbers[name]})
    indicators, score = make_indicators(config.indicators), config.score
    numbers = _numbers(indicators, only_scores=True)
    rules.make_score(score.kind, score.options)
    if len(combined := rules.combined_numbers(score, [*numbers], score.kind)) > 1:
        raise ConfigError(f"of: compensated is of one number here, not of {len(combined)}")
    return Feature(indicators, {name: numbers[name] for name in combined[0]}, score).of(combined[0])


def _numbers(
    indicators: Mapping[str, Indicator[Any]], *, only_scores: bool
) -> dict[str, tuple[str, Output, tuple[int, ...]]]:
    return {
        f"{label}.{output.name}{''.join(f'[{part}]' for part in index)}": (label, output, index)
        for label, each in indicators.items()
        for output in each.outputs
        if output.is_score or not only_scores
        for index in np.ndindex(tuple(output.dims.values()))
    }


def direction_of(config: DetectorConfig) -> Direction:
    """Direction of change by a leak: the chosen one, or that of the score."""
    feature = feature_of(config)
    own = None if feature.score is None else rules.score_kind(feature.score.kind).direction
    direction = config.direction or own or feature.described.direction
    if direction is None:
        raise ConfigError(
            f"choose the direction in which {feature.label} raises an alarm: rising, falling or both"
        )
    if own is not None and direction is not own:
        raise ConfigError(f"a leak makes {feature.label} a {own} score; found {direction}")
    return direction


def unmakable(config: DetectorConfig) -> Iterator[tuple[KeyPath, str]]:
    """Key and message of each reason for which the detector's score or chart cannot be made."""
    score, chart = config.score, config.chart
    if score is None:
        model: Any = lambda name: indicator_kind(name).Options  # noqa: E731
        own = [*_unmakable(("indicator",), sound_indicator, model, config.indicator, config.options)]
    else:
        own = [*_unmakable(("score", "kind"), rules.make_score, rules.score_kind, score.kind, score.options)]
    for key, make in (("output" if score is None else "score", feature_of), ("direction", direction_of)):
        try:
            if not own:
                make(config)
        except (ConfigError, ValidationError) as fault:
            own = [((key,), str(fault))]
    yield from own
    if chart is not None:
        made = rules.make_chart, rules.chart_kind, chart.chart, chart.options
        yield from _unmakable(("chart", "chart"), *made)


def _unmakable(
    path: KeyPath, make: Callable[..., Any], model: Callable[..., Any], name: str, options: Mapping[str, Any]
) -> Iterator[tuple[KeyPath, str]]:
    try:
        make(name, options)
    except ValidationError as errors:
        known = [*model(name).model_fields]
        for error in errors.errors():
            yield (*path[:-1], "options", *error["loc"]), describe_error(error, known)
    except ConfigError as fault:
        yield path, str(fault)


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
    """
    kind = "a detector before it is trained"
    own = None if isinstance(file, Path) else Source(plain(file or {}))
    source = read_extended(file if isinstance(file, Path) else Path("the mapping"), kind, own=own)
    given = Source({})
    for path, (option, value) in options.items():
        section = given.data
        for part in path[:-1]:
            section = section.setdefault(part, {})
        section[path[-1]] = value
        if option != dotted(path):
            given.origins[path] = option
    overlay(source, given)
    rules.normalize_chart(source, source.data.get("chart"), ("chart",), TimedChart)
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
    rules.normalize_score(source, source.data["score"], ("score",), made)
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


def options_of_machine(stated: DetectorConfig, made: Mapping[str, Indicator[Any]]) -> DetectorConfig:
    """A detector whose options are those of indicators that were made for the machine of the records."""
    if stated.score is None:
        (options,) = (each.options.model_dump(exclude_unset=True) for each in made.values())
        return stated.model_copy(update={"options": options})
    return stated.model_copy(update={"indicators": stated.indicators | stated_indicators(made)})


def setting_keys() -> dict[str, tuple[str, ...]]:
    """Keyword of `train`, and option of the command → key of `DetectorConfig`."""
    keys: dict[str, tuple[str, ...]] = {
        name: ("window", name) for name in WindowConfig.model_fields if name != "channel"
    }
    keys["window"] = keys.pop("duration")
    keys |= {name: ("chart", name) for name in ("chart", "false_alarm_every")}
    return {name: (name,) for name in DetectorConfig.model_fields} | keys


def config_of(given: Indicators) -> str | PathLike[str] | Mapping[str, Any]:
    """The configuration of a detector; labels with options, and lists of names, are its ``indicators``."""
    if isinstance(given, str | PathLike):
        return given
    keys = {"indicators", "extends", *DetectorConfig.model_fields}
    if isinstance(given, Mapping) and not keys.isdisjoint(given):
        return given
    return {"indicators": given}
