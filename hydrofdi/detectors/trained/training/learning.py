"""Training on healthy records, window by window; samples are not kept."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.detectors.trained.estimating import Estimator
from hydrofdi.detectors.trained.measuring import feature_of, without_scale
from hydrofdi.detectors.trained.ranges import joined, learned_range
from hydrofdi.detectors.trained.training.cutting import drive_of, windower_of
from hydrofdi.detectors.trained.training.estimate_scorer import EstimateScorer
from hydrofdi.detectors.trained.training.learned import Learned, LearnedRecord
from hydrofdi.detectors.trained.training.scorer import Scorer
from hydrofdi.detectors.trained.training.window_scorer import WindowScorer
from hydrofdi.errors import ConfigError, DataError, NotStatedError
from hydrofdi.indicators.measuring import output_unit, spool_remedy
from hydrofdi.indicators.plausibility import CAUSES
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.stuck import found_period
from hydrofdi.settings.readable import time_text

_WRONG_SIZES = {"unusual", "low_pressure"}
"""Kinds of remarks on channels whose unit or gain is probably wrong."""


def learn(healthy: RecordSource, config: DetectorConfig) -> Learned:
    """Train on healthy records.

    Parameters
    ----------
    healthy : RecordSource
        Only healthy records. They are read twice if windows start with cycles.
    config : DetectorConfig

    Raises
    ------
    ConfigError
        Indicator, output or windows are not valid.
    DataError
        Records lack a channel, or differ in sampling or length, or estimates are physically impossible in
        most windows.
    NotStatedError
        There are no healthy records, or none has a score.
    """
    feature, window = feature_of(config), config.window
    drive = drive_of(healthy, window.channel) if window.by == "cycle" else None
    batches = (batch for batch in healthy.batches(labels=True) if batch.n_record)
    first = next(batches, None)
    if first is None:
        raise NotStatedError(f"{healthy.name}: no healthy record")
    channels = _channels(feature, config, first)
    scorer: Scorer
    if window.by == "estimate":
        scorer = EstimateScorer(_estimator(feature, config, channels, first), channels)
    else:
        scorer = WindowScorer(windower_of(window, first, channels, drive), feature)
    records = [
        LearnedRecord(
            batch.record_ids[row], batch.groups[row], batch.labels[row] if batch.labels else "", line
        )
        for batch in chain([first], batches)
        for row, line in enumerate(scorer.lines(_checked(batch, first, channels, config)))
    ]
    scorer.finish()
    if not any(each.line.chosen.size for each in records):
        raise NotStatedError(f"no healthy record has {feature.label}: {_absence(scorer, records, config)}")
    if not config.accept:
        _require_possible(scorer, records, healthy)
    limits = {each.name: each.possible[1] or 0.0 for each in feature.indicator.outputs if each.is_fit}
    return Learned(
        records=records,
        feature=feature,
        unit=output_unit(feature.indicator, feature.described, first),
        channels=channels,
        sampling_frequency=first.sampling_frequency,
        n_sample=scorer.n_sample,
        interval=scorer.interval(records),
        ranges={channel: learned_range(channel, joined(facts)) for channel, facts in scorer.facts.items()},
        drive=drive,
        not_judged=dict(sorted(scorer.not_judged.items())),
        positive=tuple(
            each.name
            for each in feature.indicator.outputs
            if each.is_positive and not scorer.n_not_positive[each.name]
        ),
        impossible={name: count for name, count in sorted(scorer.n_impossible.items()) if count},
        fits={name: max(limit, scorer.fits.get(name, limit)) for name, limit in limits.items()},
        drive_period=found_period(first),
    )


def _require_possible(scorer: Scorer, records: Sequence[LearnedRecord], healthy: RecordSource) -> None:
    """Check that estimates are physically possible in at least half of the healthy windows.

    Raises
    ------
    DataError
        One is not.
    """
    n_window = sum(each.line.chosen.size for each in records)
    for name, count in scorer.n_impossible.items():
        if 2 * count > n_window:
            raise DataError(
                f"{healthy.name}: {name} is physically impossible in {count:,} of {n_window:,} healthy"
                f" windows: {CAUSES} --accept trains all the same"
            )


def _absence(scorer: Scorer, records: Sequence[LearnedRecord], config: DetectorConfig) -> str:
    """Message why there are no scores."""
    longest = f"the longest one lasts {time_text(max(each.line.duration for each in records))}"
    window = config.window
    if scorer.reason:
        return scorer.reason
    if window.by == "estimate":
        return f"{longest}, but the first estimate comes later; use longer records"
    if window.by == "cycle":
        return (
            f"no record has a cycle that starts with an edge of {window.channel}; choose another edge or"
            " channel"
        )
    return f"{longest}, but a window {time_text(window.duration or 0.0)}; give a shorter window"


def _channels(feature: Feature, config: DetectorConfig, first: RecordBatch) -> tuple[Channel, ...]:
    """Channels that a window needs, including optional ones of the indicator that healthy records have."""
    indicator = feature.indicator
    seen = indicator.channels | (indicator.optional_channels & first.channels.keys())
    if config.window.by == "cycle":
        seen |= {config.window.channel}
    return tuple(channel for channel in Channel if channel in seen)


def _estimator(
    feature: Feature, config: DetectorConfig, channels: Sequence[Channel], first: RecordBatch
) -> Estimator:
    if config.window.duration is not None or config.window.every is not None:
        raise ConfigError(
            f"by=estimate: this setting has no windows; the option 'interval' of"
            f" {feature.indicator.name} sets the time between estimates"
        )
    return Estimator(feature, channels, first.sampling_frequency)


def _checked(
    batch: RecordBatch, first: RecordBatch, channels: Sequence[Channel], config: DetectorConfig
) -> RecordBatch:
    """Check that a batch matches the first one, and return its channels.

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
        remedy = spool_remedy(missing, feature_of(config).indicator)
        raise DataError(
            f"{source}: has no {' and no '.join(missing)}, which {config.indicator} needs{remedy}"
        )
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
    return batch
