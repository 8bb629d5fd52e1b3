"""Scores of windows, computed identically for training, judging and streams."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import measure
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window


def feature_of(config: DetectorConfig) -> Feature:
    """Output that is the score.

    Raises
    ------
    ConfigError
        There is no such indicator or output, or the output is not a single number.
    ValidationError
        The options of the indicator are not valid.
    """
    feature = Feature(sound_indicator(config.indicator, config.options), config.output)
    if feature.described.dims:
        raise ConfigError(
            f"{feature.label} is an array, but a score is a single number; choose another output"
        )
    return feature


def records_of(
    windows: Sequence[Window], channels: Collection[Channel], sampling_frequency: float
) -> RecordBatch:
    """Windows as a batch of records that start at time 0, without a drive period.

    Parameters
    ----------
    windows : sequence of Window
        At least one; all of equal length, with all channels.
    channels : collection of Channel
    sampling_frequency : float
        Sampling frequency of the detector, not of each window [Hz], so that scores have the same meaning.
    """
    samples = {channel: np.stack([window.channels[channel] for window in windows]) for channel in channels}
    return RecordBatch(samples, sampling_frequency, tuple(str(window.number) for window in windows))


def outputs_of_records(
    records: RecordBatch, feature: Feature
) -> tuple[dict[str, Array], tuple[str | None, ...]]:
    """Outputs of valid windows by name, NaN if a window has none, and why: bit-identical whatever the other
    windows are.
    """
    measures = measure(records, {"it": feature.indicator})
    values = {name.removeprefix("it."): array for name, array in measures.values.items()}
    return values, measures.obstacles["it"]


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            found = "is normalised" if channel in records.normalized else "is in counts"
            return f"{channel} {found}, but a detector needs it in {channel.unit}"
    return None
