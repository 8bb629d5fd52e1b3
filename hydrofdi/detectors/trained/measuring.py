"""Scores of windows, computed identically for training, judging and streams."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import measure
from hydrofdi.indicators.plausibility import Doubt, doubts_of
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window


@dataclass(frozen=True)
class WindowScores:
    """Scores of windows.

    Attributes
    ----------
    values : ndarray, shape (n_window,)
        Scores in the unit of the output; NaN if a window has none.
    obstacles : tuple of (str or None), length n_window
        Why a window has no score.
    doubts : list of tuple of Doubt, length n_window
    fits : dict of str to ndarray, shape (n_window,)
        Outputs that state how well the model explains a window.
    """

    values: Array
    obstacles: tuple[str | None, ...]
    doubts: list[tuple[Doubt, ...]]
    fits: dict[str, Array]


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


def scores_of_records(
    records: RecordBatch, feature: Feature, fits: Mapping[str, float] | None = None
) -> WindowScores:
    """Scores of valid windows; bit-identical whatever the other windows are. `fits`: as of `doubts_of`."""
    measures = measure(records, {"it": feature.indicator})
    values = {name.removeprefix("it."): array for name, array in measures.values.items()}
    return WindowScores(
        values[feature.described.name],
        measures.obstacles["it"],
        doubts_of(feature.indicator, values, fits=fits),
        {each.name: values[each.name] for each in feature.indicator.outputs if each.is_fit},
    )


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Message about a channel that is not in SI; None if all are. Streams are always in SI."""
    for channel in channels:
        if channel in records.relative:
            found = "is normalised" if channel in records.normalized else "is in counts"
            return f"{channel} {found}, but a detector needs it in {channel.unit}"
    return None
