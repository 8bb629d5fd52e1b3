"""Consistency checks of a detector file, in itself and with this version of hydrofdi."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import ValidationError

from hydrofdi.detectors.charts.registry import chart_kind, make_chart
from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.evaluation.direction import Direction
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.indicators.registry import indicator_kind, sound_indicator
from hydrofdi.settings.counting import counted
from hydrofdi.settings.messages import describe_error
from hydrofdi.settings.quantities import Section
from hydrofdi.settings.yaml_source import dotted


def inconsistencies(file: DetectorFile) -> Iterator[Issue]:
    """Mistakes that make a detector file unusable, each with its key."""
    yield from _of_indicator(file)
    yield from _of_numbers(file)
    yield from _of_windows(file)
    yield from _of_chart(file)


def _of_indicator(file: DetectorFile) -> Iterator[Issue]:
    config = file.config
    try:
        indicator = sound_indicator(config.indicator, config.options)
    except ConfigError as error:
        yield Issue(str(error), "config.indicator")
        return
    except ValidationError as errors:
        yield from _of_options(errors, indicator_kind(config.indicator).Options, "config.options")
        return
    try:
        output = Feature(indicator, config.output).described
    except ConfigError as error:
        yield Issue(str(error), "config.output")
        return
    if indicator.version != file.indicator_version:
        yield Issue(
            f"{config.indicator} has version {indicator.version} here, not {file.indicator_version};"
            " train the detector again",
            "indicator_version",
        )
    if output.dims:
        yield Issue(f"{output.name} is not a single number", "config.output")
    if missing := sorted(indicator.channels - set(file.channels)):
        yield Issue(f"{config.indicator} needs {missing[0]}, which is missing", "channels")
    if config.window.by == "estimate" and not isinstance(indicator, RecursiveIndicator):
        yield Issue(f"{config.indicator} does not follow a stream; use 'time' or 'cycle'", "config.window.by")


def _of_numbers(file: DetectorFile) -> Iterator[Issue]:
    limits, direction = file.limits, file.config.direction
    if direction is None:
        yield Issue("is missing", "config.direction")
    if not file.config.output:
        yield Issue("is missing", "config.output")
    if (limits.low is None) is not (direction is Direction.RISING):
        yield Issue(
            "a lower limit is required unless the direction is rising, and allowed only then", "limits.low"
        )
    if (limits.high is None) is not (direction is Direction.FALLING):
        yield Issue(
            "an upper limit is required unless the direction is falling, and allowed only then", "limits.high"
        )
    if limits.low is not None and limits.high is not None and limits.low > limits.high:
        yield Issue(f"must not be below limits.low; found {limits.high:g}", "limits.high")
    if not 0.0 <= limits.interval[0] <= limits.interval[1] <= 1.0:
        yield Issue("expected two values from 0 to 1, the lower one first", "limits.interval")
    centre = file.healthy.centre
    if limits.low is not None and limits.low > centre:
        yield Issue(f"must not be above healthy.centre; found {limits.low:g}", "limits.low")
    if limits.high is not None and limits.high < centre:
        yield Issue(f"must not be below healthy.centre; found {limits.high:g}", "limits.high")
    for channel, limits_of_channel in file.ranges.items():
        for name in ("low", "high", "activity"):
            low, high = getattr(limits_of_channel, name)
            if low > high:
                yield Issue("the lower value must come first", f"ranges.{channel}.{name}")
        if limits_of_channel.low[0] > limits_of_channel.high[1]:
            yield Issue("must not be below the range of low", f"ranges.{channel}.high")


def _of_windows(file: DetectorFile) -> Iterator[Issue]:
    window = file.config.window
    if window.by == "estimate":
        if file.n_sample:
            yield Issue("must be 0 if estimates are judged", "n_sample")
        return
    if window.duration is None:
        yield Issue("is missing", "config.window.duration")
    elif file.n_sample != round(window.duration * file.sampling_frequency) or file.n_sample < 2:
        yield Issue(
            f"{counted(file.n_sample, 'sample')} do not match config.window.duration = {window.duration:g} s",
            "n_sample",
        )
    if window.by == "time" and window.every is None:
        yield Issue("is missing", "config.window.every")
    if window.by == "cycle":
        if file.drive is None or not file.drive[0] < file.drive[1]:
            yield Issue("expected the lowest and the highest value of the drive", "drive")
        if window.channel not in file.channels:
            yield Issue(f"must contain {window.channel}, which starts the cycles", "channels")


def _of_chart(file: DetectorFile) -> Iterator[Issue]:
    if (file.config.chart is None) is not (file.chart is None):
        yield Issue("requires config.chart, and config.chart requires it", "chart")
    if file.config.chart is not None:
        try:
            make_chart(file.config.chart.chart, file.config.chart.options)
        except ConfigError as error:
            yield Issue(str(error), "config.chart.chart")
        except ValidationError as errors:
            options = chart_kind(file.config.chart.chart).Options
            yield from _of_options(errors, options, "config.chart.options")


def _of_options(errors: ValidationError, options: type[Section], key: str) -> Iterator[Issue]:
    for error in errors.errors():
        text = describe_error(error, [*options.model_fields])
        yield Issue(text, f"{key}.{dotted(error['loc'])}")
