"""Training of a detector: from healthy records, window by window, to a detector file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from itertools import chain
from typing import Any, Literal

import numpy as np

from hydrofdi.detectors.registry import make_chart, make_score
from hydrofdi.detectors.run_lengths import FalseAlarms
from hydrofdi.detectors.scores.contract import plain_data
from hydrofdi.detectors.scores.features import cross_fitted_scores, healthy_scale, known_numbers
from hydrofdi.detectors.trained.configuration import (
    ChartConfig,
    DetectorConfig,
    Feature,
    WindowConfig,
    direction_of,
    feature_of,
    stated_indicators,
)
from hydrofdi.detectors.trained.file import Basis, ChartLimit, DetectorFile, Limits, Made, Scale, TrainedScore
from hydrofdi.detectors.trained.following import Estimator, standardised
from hydrofdi.detectors.trained.measuring import joined, learned_range, without_scale
from hydrofdi.detectors.trained.scoring import EstimateScores, HealthyScores, WindowScores
from hydrofdi.errors import ConfigError, DataError, NotStatedError
from hydrofdi.evaluation.rates import Rule, alarm_rate, left_out_outcomes
from hydrofdi.evaluation.roc import FEWEST_GROUPS
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import THRESHOLDS, Threshold
from hydrofdi.indicators.faults import CAUSES
from hydrofdi.indicators.measuring import output_unit, spool_remedy
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.stuck import found_period
from hydrofdi.settings.readable import time_text

_WRONG_SIZES = {"unusual", "low_pressure"}
"""Kinds of remarks on channels whose unit or gain is probably wrong."""

_MOST_FOLDS = 25
"""Maximum number of cross-validation folds; with more groups, several are left out at a time."""

Drive = tuple[float, float]


def train(
    healthy: RecordSource,
    config: DetectorConfig,
    sources: Sequence[str],
    made: Made,
    faulty: RecordSource | None = None,
) -> DetectorFile:
    """Train a detector on healthy records.

    Parameters
    ----------
    healthy : RecordSource
        Only healthy records; the groups of their batches identify dependent records. They are read twice if
        windows start with cycles.
    config : DetectorConfig
        Configuration; the file contains it with all defaults.
    sources : sequence of str
        Names of the sources.
    made : Made
    faulty : RecordSource, optional
        Only faulty records, for scores that learn from them too.

    Raises
    ------
    ConfigError
        The indicator has no such output, no direction is stated and the output does not declare one, or
        windows are not valid.
    DataError
        The records lack a channel, or differ in sampling or length, or estimates are physically impossible in
        most windows.
    NotStatedError
        There are too few records for the false-alarm rate; the message states how many are needed.
    """
    feature, direction, window = feature_of(config), direction_of(config), config.window
    drive = _drive(healthy, window.channel) if window.by == "cycle" else None
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    first = next(batches, None)
    if first is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    channels = _channels(feature, config, first)
    found = _scorer(feature, window, first, channels, drive)
    for batch in chain([first], batches):
        _check(batch, first, channels, config)
        found.take(batch)
    found.finish()
    trained = _learn(found, feature, config, _teachers(faulty, found, first, channels, config))
    _require_scores(found, feature, config, healthy)
    chart = _chart(config, found, direction)
    limits = limits_of(found, config, direction)
    centre, spread = healthy_scale(found.scores)
    lowest, highest = float(np.nanmin(found.scores)), float(np.nanmax(found.scores))
    own = Scale(centre=centre, spread=spread, range=(lowest, highest))
    used = feature if trained is None else feature.of(trained.numbers)
    fits = {name: each.possible[1] or 0.0 for name, each in used.outputs if each.is_fit}
    return DetectorFile(
        made=made,
        config=_in_full(config, found, feature, direction, chart),
        indicator_versions={label: each.version for label, each in used.indicators.items()},
        score=trained,
        unit=_unit(feature, first),
        channels=channels,
        sampling_frequency=first.sampling_frequency,
        n_sample=found.n_sample,
        basis=_basis(found, sources, found_period(first)),
        healthy=own,
        limits=limits,
        chart=None if chart is None else _chart_limit(found, chart, own, direction, config.confidence),
        ranges={channel: learned_range(channel, joined(facts)) for channel, facts in found.facts.items()},
        positive=tuple(
            name for name, each in used.outputs if each.is_positive and not found.n_not_positive[name]
        ),
        fits={name: max(limit, found.fits.get(name, limit)) for name, limit in fits.items()},
        drive=drive,
    )


def _drive(healthy: RecordSource, channel: Channel) -> Drive:
    """Lowest and highest value of the channel whose edges start cycles, over all healthy records."""
    low, high = np.inf, -np.inf
    for batch in healthy.batches(labels=True):
        if batch.n_record and channel in batch.channels:
            low = min(low, float(np.nanmin(batch[channel])))
            high = max(high, float(np.nanmax(batch[channel])))
    if not low < high:
        found = "is missing in" if high == -np.inf else "never changes in"
        raise NotStatedError(
            f"by=cycle: {channel} {found} all healthy records, but cycles start at its edges;"
            " choose another channel under 'window:', or use windows by time"
        )
    return low, high


def _channels(feature: Feature, config: DetectorConfig, first: RecordBatch) -> tuple[Channel, ...]:
    """Channels that a window needs, including optional ones of the indicator that healthy records have."""
    seen = feature.channels | (feature.optional_channels & first.channels.keys())
    if config.window.by == "cycle":
        seen |= {config.window.channel}
    return tuple(channel for channel in Channel if channel in seen)


def _scorer(
    feature: Feature,
    window: WindowConfig,
    first: RecordBatch,
    channels: Sequence[Channel],
    drive: Drive | None,
) -> HealthyScores:
    """What scores windows or estimates; without a duration, windows are whole records."""
    frequency = first.sampling_frequency
    if window.by == "estimate":
        if feature.score is not None:
            raise ConfigError("by=estimate: a score of several numbers is judged by windows")
        if window.duration is not None or window.every is not None:
            raise ConfigError(
                f"by=estimate: this setting has no windows; the option 'interval' of"
                f" {feature.indicator.name} sets the time between estimates"
            )
        return EstimateScores(Estimator(feature, channels, frequency), channels)
    if window.by == "cycle" and window.duration is None:
        raise ConfigError("by=cycle: give the length of each cycle, counted from its edge, as 'window'")
    if window.by == "cycle" and window.every is not None:
        raise ConfigError("every: windows by cycle start at the edges of the drive; remove this setting")
    duration = first.duration if window.duration is None else window.duration
    n_sample = round(duration * frequency)
    if n_sample < 2:
        raise ConfigError(
            f"window: {duration:g} s at {frequency:g} Hz contain {n_sample} samples; use at least 2"
        )
    return WindowScores(window.windower(n_sample, channels, frequency, drive), feature)


def _check(
    batch: RecordBatch, first: RecordBatch, channels: Sequence[Channel], config: DetectorConfig
) -> None:
    """Check that a batch matches the first one.

    Raises
    ------
    DataError
        Sampling, channels or lengths differ.
    """
    source, other = batch.sources[0], first.sources[0]
    if batch.sampling_frequency != first.sampling_frequency:
        raise DataError(
            f"{source}: is sampled at {batch.sampling_frequency:g} Hz, but {other} at"
            f" {first.sampling_frequency:g} Hz; a detector needs a single sampling frequency"
        )
    if missing := [channel for channel in channels if channel not in batch.channels]:
        indicators = feature_of(config).indicators.items()
        needing = [(label, each) for label, each in indicators if not each.channels.isdisjoint(missing)]
        label, needs = needing[0] if needing else (config.window.by, feature_of(config).indicator)
        remedy = spool_remedy(missing, needs)
        raise DataError(f"{source}: has no {' and no '.join(missing)}, which {label} needs{remedy}")
    if obstacle := without_scale(batch, channels):
        raise DataError(f"{source}: {obstacle}")
    for remark in chain.from_iterable(() if config.accept else batch.remarks):
        if remark.kind in _WRONG_SIZES and remark.where in channels:
            raise DataError(f"{source}: {remark.message}; --accept trains all the same")
    needs_length = config.window.by == "time" and config.window.duration is None
    if needs_length and batch.n_time != first.n_time:
        raise DataError(
            f"{source}: lasts {batch.duration:g} s, but {other} {first.duration:g} s; give the duration of a"
            f" window as 'window'"
        )


def _teachers(
    faulty: RecordSource | None,
    found: HealthyScores,
    first: RecordBatch,
    channels: Sequence[Channel],
    config: DetectorConfig,
) -> HealthyScores | None:
    """Windows of faulty records, measured as the healthy ones.

    A study deals them to the folds of every score, also of those that do not learn from them.
    """
    if faulty is None or config.score is None:
        return None
    assert isinstance(found, WindowScores)
    teachers = WindowScores(found.windower, found.feature)
    for batch in faulty.batches(labels=True):
        if batch.n_record:
            _check(batch, first, channels, config)
            teachers.take(batch)
    teachers.finish()
    return teachers


_N_PIECE = 20
"""Pieces of a single record by which a score is cross-fitted, and of few records for the limit of a chart."""


def _learn(
    found: HealthyScores, feature: Feature, config: DetectorConfig, teachers: HealthyScores | None
) -> TrainedScore | None:
    """Set the scores of healthy windows: the number itself, or the cross-fitted score of several.

    Raises
    ------
    NotStatedError
        There are too few windows for the score.
    """
    n_healthy = sum(len(line.numbers) for line in found.lines)
    if config.score is None or not n_healthy:
        found.set_scores(found.numbers[:, 0] if n_healthy else np.empty(0))
        return None
    both = [found] if teachers is None or not teachers.numbers.size else [found, teachers]
    values = np.concatenate([each.numbers for each in both])
    is_fit = np.concatenate([each.is_apart for each in both])
    is_faulty = np.arange(len(values)) >= n_healthy
    score = make_score(config.score.kind, config.score.options)
    kept = known_numbers(values[is_fit & (score.needs_faulty | ~is_faulty)])
    if not kept:
        raise NotStatedError(f"no number of {feature.label} is measured in at least 90 % of the windows")
    lines = [line for each in both for line in each.lines]
    groups = np.repeat(
        [line.group or f"record {place:09d}" for place, line in enumerate(lines)],
        [len(line.numbers) for line in lines],
    ).tolist()
    if len(set(groups)) == 1:
        groups = [f"piece {_N_PIECE * place // n_healthy}" for place in range(n_healthy)]
    used = np.ascontiguousarray(values[:, kept])
    scores = cross_fitted_scores(score, used, is_faulty, groups, is_fit=is_fit)
    found.set_scores(scores[:n_healthy])
    fitted = score.fit(used[is_fit], is_faulty[is_fit])
    return TrainedScore(
        numbers=tuple(feature.numbers[place].name for place in kept),
        rule=plain_data(fitted.rule),
        n_healthy=fitted.n_healthy,
        n_faulty=fitted.n_faulty,
    )


def _chart(config: DetectorConfig, found: HealthyScores, direction: Direction) -> ChartConfig | None:
    """The chart that is asked for; one with the usual promise if nothing is said and the records carry it."""
    chart, usual = config.chart, ChartConfig()
    if "chart" not in config.model_fields_set and found.hours * 3600.0 >= usual.false_alarm_every:
        chart = usual
    return None if chart is None else _chart_in_full(chart, direction)


def _chart_in_full(chart: ChartConfig, direction: Direction) -> ChartConfig:
    """Chart configuration with all options; the direction refers to scores that rise with leakage."""
    turned = Direction.BOTH if direction is Direction.BOTH else Direction.RISING
    made = make_chart(chart.chart, {"direction": turned, **chart.options})
    return chart.model_copy(update={"options": made.options.model_dump(mode="json")})


def _chart_limit(
    found: HealthyScores, chart: ChartConfig, healthy: Scale, direction: Direction, confidence: float
) -> ChartLimit:
    """Limit that healthy scores, in time order, reach once within the required time on average.

    Parameters
    ----------
    found : HealthyScores
    chart : ChartConfig
        Chart configuration with all options.
    healthy : Scale
    direction : Direction
        Direction of the score.
    confidence : float

    Raises
    ------
    NotStatedError
        The healthy records are shorter in total than the required time; the message states the required
        length.
    """
    lines = [standardised(each.scores, healthy, direction) for each in found.lines]
    groups: list[str] | None = None
    rests_on: Literal["pieces", "records", "groups"] = "pieces"
    if len(set(found.groups)) >= FEWEST_GROUPS:
        groups, rests_on = found.groups, "groups" if found.has_groups else "records"
    else:
        length = max(1, sum(line.size for line in lines) // _N_PIECE)
        lines = [line[first : first + length] for line in lines for first in range(0, line.size, length)]
    streams = np.full((len(lines), max(line.size for line in lines)), np.nan)
    for row, line in enumerate(lines):
        streams[row, : line.size] = line
    alarms = FalseAlarms(
        make_chart(chart.chart, chart.options), streams, found.interval, groups=groups
    ).limit(chart.false_alarm_every, confidence=confidence)
    return ChartLimit(
        limit=alarms.value,
        mean_time=_finite(alarms.mean_time),
        interval=(alarms.low, _finite(alarms.high)),
        hours=alarms.duration / 3600.0,
        rests_on=rests_on,
    )


def _finite(value: float) -> float | None:
    """The value; None if it is infinite."""
    return value if np.isfinite(value) else None


def _unit(feature: Feature, records: RecordBatch) -> str:
    """Unit of the score: that of its number; scores of several have none, but for compensated numbers."""
    if feature.score is not None and feature.score.kind != "compensated":
        return "1"
    return output_unit(feature.indicator, feature.described, records)


def _require_scores(
    found: HealthyScores, feature: Feature, config: DetectorConfig, healthy: RecordSource
) -> None:
    """Check that there are scores, and that estimates are possible in at least half of the windows.

    Raises
    ------
    DataError, NotStatedError
        They are not.
    """
    if not found.scores.size:
        reason = next((text for text, _ in found.reasons.most_common(1)), "") or _absence(found, config)
        raise NotStatedError(f"no healthy record has {feature.label}: {reason}")
    for name, count in () if config.accept else found.n_impossible.items():
        if 2 * count > found.scores.size:
            raise DataError(
                f"{healthy.name}: {name} is physically impossible in {count:,} of {found.scores.size:,}"
                f" healthy windows: {CAUSES} --accept trains all the same"
            )


def _absence(found: HealthyScores, config: DetectorConfig) -> str:
    """Why there are no windows."""
    longest = f"the longest one lasts {time_text(max(line.duration for line in found.lines))}"
    window = config.window
    if window.by == "estimate":
        return f"{longest}, but the first estimate comes later; use longer records"
    if window.by == "cycle":
        return f"no record has a cycle that starts with an edge of {window.channel}; choose another"
    return f"{longest}, but a window {time_text(window.duration or 0.0)}; give a shorter window"


def _in_full(
    config: DetectorConfig,
    found: HealthyScores,
    feature: Feature,
    direction: Direction,
    chart: ChartConfig | None,
) -> DetectorConfig:
    """Configuration with all defaults filled in."""
    window = config.window
    if found.n_sample:
        every = window.every or (found.duration if window.by == "time" else None)
        window = window.model_copy(update={"duration": found.duration, "every": every})
    own: dict[str, Any] = {"indicators": stated_indicators(feature.indicators, in_full=True)}
    if feature.score is None:
        options = feature.indicator.options.model_dump(mode="json")
        own = {"options": options, "output": feature.label.removeprefix(f"{config.indicator}.")}
    return config.model_copy(
        update={
            **own,
            "direction": direction,
            "window": window,
            "chart": chart,
        }
    )


def _basis(found: HealthyScores, sources: Sequence[str], drive_period: float | None) -> Basis:
    populations: Counter[str] = Counter()
    for line in found.lines:
        populations[line.label] += line.chosen.size
    del populations[""]
    return Basis(
        sources=tuple(sources),
        n_record=len(found.lines),
        n_window=found.scores.size,
        n_group=len(set(found.groups)) if found.has_groups else 0,
        populations=dict(sorted(populations.items())),
        not_judged=dict(sorted(found.not_judged.items())),
        impossible={name: count for name, count in sorted(found.n_impossible.items()) if count},
        drive_period=drive_period,
    )


def limits_of(found: HealthyScores, config: DetectorConfig, direction: Direction) -> Limits:
    """Set the limits of a score.

    If records or groups have several windows each, the interval of the false-alarm rate is cross-validated:
    each record or group is tested with the limits of the others. Otherwise, or if too few windows remain
    without a record, windows are assumed independent and the interval follows from order statistics. If
    groups are stated, windows of a group are dependent, and too few groups are an error.

    Raises
    ------
    NotStatedError
        There are too few windows; the message states how many are needed.
    """
    kind = THRESHOLDS[config.threshold]
    rate, confidence = config.false_alarm_rate, config.confidence
    rule = partial(kind, false_alarm_rate=rate, direction=direction, confidence=confidence)
    threshold = _set(rule, found.scores, found, "there are")
    rests_on, interval = _interval(rule, found, threshold)
    return Limits(
        low=_finite(threshold.low),
        high=_finite(threshold.high),
        false_alarm_rate=config.false_alarm_rate,
        interval=interval,
        confidence=config.confidence,
        method=threshold.method,
        interval_rests_on=rests_on,
    )


def _interval(
    rule: Rule, found: HealthyScores, threshold: Threshold
) -> tuple[Literal["windows", "records", "groups"], tuple[float, float]]:
    groups: Any = found.of_scores
    n_group = np.unique(groups).size
    if n_group < 2 or n_group == groups.size:
        return "windows", threshold.interval
    try:
        outcomes = left_out_outcomes(
            found.scores,
            groups % _MOST_FOLDS,
            lambda scores: _set(rule, scores, found, "without one of the groups there are"),
        )
    except NotStatedError:
        if found.has_groups:
            raise
        return "windows", threshold.interval
    rate = alarm_rate(outcomes, groups=groups, confidence=threshold.confidence)
    return "groups" if found.has_groups else "records", (rate.low, rate.high)


def _set(rule: Rule, scores: Array, found: HealthyScores, there_are: str) -> Threshold:
    try:
        return rule(scores)
    except NotStatedError as refusal:
        needed = refusal.records_needed
        if needed is None:
            raise
        promise = str(refusal).partition(" needs ")[0]
        what = "windows that do not overlap" if found.n_sample else "estimates"
        lasting = time_text(needed * found.duration)
        remedy = "more records, shorter windows" if found.n_sample else "more records"
        raise NotStatedError(
            f"{promise} needs {needed:,} healthy {what} ({lasting}), and {there_are} {scores.size:,};"
            f" take {remedy} or a higher false_alarm_rate",
            needed,
        ) from None
