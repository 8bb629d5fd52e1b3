"""Faults of a window that its samples show."""

from __future__ import annotations

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.stuck import frozen_time, must_change
from hydrofdi.settings.counting import counted

_RATE = 0.01
"""Share of the sampling frequency by which the mean rate of a window may differ."""


def fault_of(
    time: Array, samples: Array, channels: tuple[Channel, ...], n_sample: int, sampling_frequency: float
) -> Issue | None:
    """The first fault of a window, in the order: length, rate, missing samples, stuck channels.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        [s]
    samples : ndarray, shape (n_channel, n_time)
        In SI.
    channels : tuple of Channel, length n_channel
    n_sample : int
        Samples that a window should have.
    sampling_frequency : float
        Expected [Hz].
    """
    if time.size < n_sample:
        return Issue(
            f"the cycle has {counted(time.size, 'sample')} instead of {n_sample}", kind="short_cycle"
        )
    lows, highs = samples.min(axis=1), samples.max(axis=1)
    return (
        _other_rate(time, sampling_frequency)
        or _missing(samples, channels, lows, highs)
        or _stuck(samples, channels, lows == highs, sampling_frequency)
    )


def _other_rate(time: Array, sampling_frequency: float) -> Issue | None:
    rate = (time.size - 1) / float(time[-1] - time[0]) if time.size > 1 else sampling_frequency
    if abs(rate - sampling_frequency) <= _RATE * sampling_frequency:
        return None
    return Issue(f"samples come at {rate:.4g} Hz instead of {sampling_frequency:.4g} Hz", kind="other_rate")


def _missing(samples: Array, channels: tuple[Channel, ...], lows: Array, highs: Array) -> Issue | None:
    for row in np.flatnonzero(~(np.isfinite(lows) & np.isfinite(highs))):
        n_missing = int(np.count_nonzero(~np.isfinite(samples[row])))
        if n_missing == samples.shape[1]:
            return Issue(f"{channels[row]} is missing", kind="missing_channel")
        text = (
            f"{n_missing} of {counted(samples.shape[1], 'sample')} of"
            f" {channels[row]} are missing or not finite"
        )
        return Issue(text, kind="missing")
    return None


def _stuck(
    samples: Array, channels: tuple[Channel, ...], is_constant: Array, sampling_frequency: float
) -> Issue | None:
    for row in np.flatnonzero(is_constant):
        if must_change(channels[row]):
            return Issue(f"{channels[row]} never changes", kind="stuck")
    held = dict(zip(channels, samples, strict=True))
    if frozen := frozen_time(held, sampling_frequency):
        return Issue(
            f"{Channel.PISTON_POSITION} does not change for {frozen:.3g} s while the pressures do",
            kind="stuck",
        )
    return None
