"""Defects of the channels of a record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import LimitsConfig
from hydrofdi.records.measured.findings.hum import hum_share
from hydrofdi.records.measured.findings.sizes import unusual_sizes
from hydrofdi.records.measured.recording import Recording
from hydrofdi.records.stuck import frozen_time, is_ideal_rail, must_change
from hydrofdi.settings.counting import counted

_SPIKE = 20.0
"""A spike is farther from the median than this multiple of the range from the 1 % to the 99 % quantile."""
_PILE = 3
"""Clipping needs more than this ratio of samples at the limit to samples at the next value. Coarse
quantization has a smaller ratio."""
Ranges = Mapping[Channel, tuple[float, float]]
"""Lowest and highest plausible value, in the unit of the channel."""


def defects(recording: Recording, limits: LimitsConfig, ranges: Ranges) -> Iterator[Issue]:
    """Remarks on a record and on each of its channels.

    Parameters
    ----------
    recording : Recording
    limits : LimitsConfig
    ranges : mapping of Channel to (float, float)
        Plausible values, if known.
    """
    if limits.samples is not None and recording.n_time != limits.samples:
        text = f"has {counted(recording.n_time, 'sample')} instead of {limits.samples}"
        yield Issue(text, kind="wrong_length")
    yield from unusual_sizes(recording)
    for channel, samples in recording.channels.items():
        yield from _of_channel(recording, channel, samples, limits, ranges)


def _of_channel(
    recording: Recording, channel: Channel, samples: Array, limits: LimitsConfig, ranges: Ranges
) -> Iterator[Issue]:
    missing = int(np.count_nonzero(~np.isfinite(samples)))
    if missing:
        text = (
            f"{missing} of {counted(samples.size, 'sample')} of {channel} are missing or not finite; to use"
            " the rest, set 'trim' or 'cycles' in a description, or judge windows"
        )
        yield Issue(text, channel, kind="missing", is_unusable=True)
        return
    if channel in ranges:
        yield from _out_of_range(channel, samples, ranges[channel])
    if channel is Channel.PISTON_POSITION and (
        frozen := frozen_time(recording.channels, recording.sampling.frequency)
    ):
        text = f"{channel} does not change for {frozen:.3g} s while the pressures do"
        yield Issue(text, channel, kind="stuck", is_unusable=True)
        return
    if np.ptp(samples) == 0.0:
        if not is_ideal_rail(channel, float(samples[0])):
            yield Issue(f"{channel} never changes", channel, kind="stuck", is_unusable=_is_unusable(channel))
        return
    if channel is not Channel.INPUT_VOLTAGE:
        yield from _spikes(recording, channel, samples)
    if channel.is_pressure:
        yield from _clipped(recording, channel, samples, limits.clipped)
    yield from _hum(recording, channel, samples, limits)


def _is_unusable(channel: Channel) -> bool:
    """Whether a channel that never changes is unusable."""
    return must_change(channel) or channel is Channel.SUPPLY_PRESSURE


def _out_of_range(channel: Channel, samples: Array, limits: tuple[float, float]) -> Iterator[Issue]:
    outside = float(np.mean((samples < limits[0]) | (samples > limits[1])))
    if outside:
        yield Issue(f"{outside:.2%} of {channel} samples lie outside its range", channel, kind="out_of_range")


def _spikes(recording: Recording, channel: Channel, samples: Array) -> Iterator[Issue]:
    low, middle, high = np.quantile(samples, [0.01, 0.5, 0.99])
    away = np.abs(samples - middle)
    n_far = int(np.count_nonzero(away > _SPIKE * (high - low)))
    if n_far and n_far < samples.size / 100:
        farthest = int(np.argmax(away))
        value = f"{samples[farthest]:.4g} {recording.unit(channel)}"
        text = f"implausible samples of {channel}: {n_far}, such as {value} at sample {farthest + 1}"
        yield Issue(text, channel, kind="spike")


def _clipped(recording: Recording, channel: Channel, samples: Array, limit: float) -> Iterator[Issue]:
    for kind, end, sign in (("clipped", "lowest", 1.0), ("saturated", "highest", -1.0)):
        extreme = sign * np.min(sign * samples)
        n_extreme = int(np.count_nonzero(samples == extreme))
        share = n_extreme / samples.size
        if share > limit and n_extreme > _PILE * _at_next_value(sign * samples):
            text = (
                f"{share:.1%} of {channel} samples lie at the {end} value,"
                f" {extreme:.4g} {recording.unit(channel)}"
            )
            yield Issue(text, channel, kind=kind)


def _at_next_value(samples: Array) -> int:
    """Number of samples with the second lowest value."""
    above = samples[samples > samples.min()]
    return int(np.count_nonzero(above == above.min()))


def _hum(recording: Recording, channel: Channel, samples: Array, limits: LimitsConfig) -> Iterator[Issue]:
    shares = {mains: hum_share(samples, recording.sampling.frequency, mains) for mains in limits.mains}
    mains = max(shares, key=shares.__getitem__)
    if shares[mains] > limits.hum:
        text = f"{shares[mains]:.0%} of the power of {channel} above 20 Hz is hum of {mains:g} Hz"
        yield Issue(text, channel, kind="hum")
