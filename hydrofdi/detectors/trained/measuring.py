"""Windows → scores: the same for training, for judging and for streams."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.errors import ConfigError
from hydrofdi.indicators import measure
from hydrofdi.indicators.registry import sound_indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.streams import Window


@dataclass(frozen=True)
class WindowScores:
    """What an indicator says of windows.

    Attributes
    ----------
    values : ndarray, shape (n_window,)
        In the unit of the output; NaN if a window has none.
    obstacles : tuple of (str or None), length n_window
        Why a window has no number.
    """

    values: Array
    obstacles: tuple[str | None, ...]


def feature_of(config: DetectorConfig) -> Feature:
    """The output that is the score.

    Raises
    ------
    ConfigError
        There is no such indicator or output, or the output is no single number.
    ValidationError
        The options of the indicator are mistaken.
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
    """Windows side by side as records that begin at 0; the period of the drive is not told.

    Parameters
    ----------
    windows : sequence of Window
        At least one; all of equal length, with all channels.
    channels : collection of Channel
    sampling_frequency : float
        [Hz]; that of the detector, not that of each window, so that a window cannot change its meaning.
    """
    samples = {channel: np.stack([window.channels[channel] for window in windows]) for channel in channels}
    return RecordBatch(samples, sampling_frequency, tuple(str(window.number) for window in windows))


def scores_of_records(records: RecordBatch, feature: Feature) -> WindowScores:
    """Scores of sound windows. That of a window does not depend, to the bit, on the others."""
    measures = measure(records, {"it": feature.indicator})
    return WindowScores(measures.values[f"it.{feature.described.name}"], measures.obstacles["it"])


def without_scale(records: RecordBatch, channels: Collection[Channel]) -> str | None:
    """Which channel is not in SI, as a sentence; None if all are. A stream has no scale but SI."""
    for channel in channels:
        if channel in records.relative:
            found = "is divided by another" if channel in records.normalized else "is in counts"
            return f"{channel} {found}, and a detector needs it in {channel.unit}"
    return None
