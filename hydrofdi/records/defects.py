"""Defects of measured records: missing, stuck, held and clipped samples, hum, and strange sizes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import Issue
from hydrofdi.records import Array, Channel
from hydrofdi.records.description import RemarkLimits
from hydrofdi.records.recording import Record
from hydrofdi.records.times import other_unit, uneven_window
from hydrofdi.settings import quantities as usual
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import ABOVE, BELOW
from hydrofdi.units import parse_quantity

_FROZEN_FOR, _FROZEN_MOVE = 1.0, 0.3
"""A position is stuck if it repeats one value for longer than the first number [s], while the 5 … 95 % range
of a pressure exceeds the second, a share of the largest pressure: no friction holds a piston against that."""
_CHAMBERS = (Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE)
_RAILS = (Channel.SUPPLY_PRESSURE, Channel.RETURN_PRESSURE)
"""Both are constant if the supply is ideal; a trained detector knows whether they were in healthy records."""


def must_change(channel: Channel) -> bool:
    """Whether a channel that is constant throughout is stuck."""
    return (channel.is_pressure and channel not in _RAILS) or channel is Channel.PISTON_VELOCITY


def frozen(channels: Mapping[Channel, Array], sampling_frequency: float) -> str:
    """That the position repeats a value for long; empty if it does not, or pressures rest."""
    position = channels.get(Channel.PISTON_POSITION)
    apart = max(1, int(_FROZEN_FOR * sampling_frequency / 2.0))
    if position is None or not np.any(position[apart::apart] == position[:-apart:apart]):
        return ""  # a longer run contains two neighbours of this grid
    lengths, still = _repetitions(position)
    time = float(lengths.max() / sampling_frequency)
    chambers = [channels[chamber] for chamber in _CHAMBERS if chamber in channels]
    pressures = [samples for samples in chambers if np.isfinite(samples).all()]
    if time <= _FROZEN_FOR or not pressures:
        return ""
    moves = max(float(np.ptp(np.quantile(samples[still], [0.05, 0.95]))) for samples in pressures)
    level = max(float(np.max(np.abs(samples))) for samples in pressures)
    is_moving = moves > _FROZEN_MOVE * level
    return f"{Channel.PISTON_POSITION} does not change for {time:.3g} s while the pressures do" * is_moving


def _repetitions(samples: Array) -> tuple[NDArray[np.intp], slice]:
    """How long each value is repeated, and the samples of the longest repetition."""
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(samples)) + 1, [samples.size]])
    lengths = np.diff(bounds)
    longest = int(np.argmax(lengths))
    return lengths, slice(int(bounds[longest]), int(bounds[longest + 1]))


_LONGER, _MOVES, _STEPS = 10.0, 0.1, 4.0
"""A channel is frozen if it repeats a value for this many times its next longest repetition, and for the
first number above, while another channel moves by this share of its range, or after steps of this many
digits."""


def frozen_stretch(
    channel: Channel, channels: Mapping[Channel, Array], sampling_frequency: float
) -> slice | None:
    """The samples in which a channel repeats a value as it never does otherwise; None if there are none.

    Commands may rest, rails be ideal, and values at an end of the range be clipped.
    """
    samples = channels[channel]
    lengths, stretch = _repetitions(samples)
    if channel in (Channel.INPUT_VOLTAGE, *_RAILS) or lengths.size <= _FEWEST_TURNS:
        return None
    *_, others, longest = np.sort(lengths)
    is_end = samples[stretch.start] in (samples.min(), samples.max())
    if is_end or longest <= max(_FROZEN_FOR * sampling_frequency, _LONGER * others):
        return None
    moving = (values for other, values in channels.items() if other is not channel and np.ptp(values) > 0.0)
    if any(np.ptp(values[stretch]) > _MOVES * np.ptp(values) for values in moving):
        return stretch
    steps = np.abs(np.diff(samples[: stretch.start + 1]))
    is_abrupt = steps.size > 2 and np.median(steps[-5:]) > _STEPS * steps[steps > 0.0].min()
    return stretch if is_abrupt else None


_FEWEST_TURNS, _VARIED, _ROUNDING = 20, 3.0, 1e-13
"""Fewest changes that show a rate; least ratio of their median size to their 10 % quantile if they are those
of a held signal: the changes of a coarse converter are all of one digit; share of values that is rounding."""


def update_rate(samples: Array, times: Array) -> float | None:
    """How often a channel is really updated [Hz]: its samples repeat, or lie on lines between fewer; None if
    neither is so."""
    changes = np.abs(np.diff(samples))
    turns = np.flatnonzero(changes)
    if turns.size < _FEWEST_TURNS:
        return None
    if np.median(np.diff(turns)) < 2.0:
        steps = np.diff(times)
        changes = np.abs(np.diff(np.diff(samples) / steps))
        rounding = _ROUNDING * float(np.max(np.abs(samples)) / steps.min())
        bent = np.flatnonzero(changes > max(0.02 * np.quantile(changes, 0.98), rounding))
        turns = bent[np.diff(bent, prepend=-2) > 1]  # a knot between two samples bends the line at both
        if turns.size < max(_FEWEST_TURNS, 0.45 * bent.size) or np.quantile(np.diff(turns), 0.1) < 2.0:
            return None
    low, middle = np.quantile(changes[turns], [0.1, 0.5])
    if not middle > _VARIED * low:
        return None
    between = np.diff(times[turns])  # the longest are left out, as a channel rests in them
    return float(1.0 / np.mean(between[between <= 1.6 * np.median(between)]))


_LOWEST = 20.0
_PERIODS = 16.0
"""Fewest periods of the mains in a record that is checked."""
_PERIODS_OF_PART = 8.0
"""Periods of the mains in each part of a record. The amplitudes of the parts are compared."""
_PARTS_AT_ONCE = 2048
_STEADY = 0.7
"""Least ratio of a steady line's lower amplitudes (their first quartile over the parts) to the median. It is
1 for a sine, 0.64 for narrow-band noise (Rayleigh), and near 0 for a mode that decays between strokes.
Clipping may hide a line for a quarter of a record."""


def hum_share(samples: Array, sampling_frequency: float, mains: float) -> float:
    """Share of the power above 20 Hz in steady lines at the mains frequency [Hz] and its harmonics.

    A line is steady if its amplitude lasts through the record, also while the machine rests.
    """
    if samples.size < _PERIODS * sampling_frequency / mains - 1e-6 or mains >= sampling_frequency / 2.0:
        return 0.0
    harmonics = mains * np.arange(1, int(ABOVE * sampling_frequency / 2.0 / mains) + 1, dtype=np.float64)
    steady = harmonics[_are_steady(samples, sampling_frequency, mains, harmonics)]
    if not steady.size:
        return 0.0
    power = _spectrum(samples - samples.mean()) ** 2
    step = sampling_frequency / samples.size
    frequency = np.arange(power.size) * step
    # A Hann window spreads a line over two bins to each side; the excess keeps the bin at the edge.
    width = 2.000001 * step
    at_line = np.zeros(power.size, dtype=bool)
    for harmonic in steady.tolist():
        at_line |= np.abs(frequency - harmonic) <= width
    counted = frequency >= BELOW * _LOWEST
    total = float(power[counted].sum())
    return float(power[at_line & counted].sum()) / total if total > 0.0 else 0.0


def _are_steady(
    samples: Array, sampling_frequency: float, mains: float, harmonics: Array
) -> NDArray[np.bool_]:
    """Whether the amplitude at each harmonic lasts, shape (n_harmonic,)."""
    n_part = round(_PERIODS_OF_PART * sampling_frequency / mains)
    parts = np.lib.stride_tricks.sliding_window_view(samples, n_part)[:: max(1, n_part // 2)]
    bins = np.minimum(np.rint(harmonics * n_part / sampling_frequency).astype(int), n_part // 2)
    # some parts at a time, because together they take many times the memory of the samples
    some = np.array_split(parts, max(1, len(parts) // _PARTS_AT_ONCE))
    spectra = (_spectrum(part - part.mean(axis=1, keepdims=True))[:, bins] for part in some)
    # The first quartile, not the minimum: clipping may hide the line in some parts.
    low, median = np.quantile(np.concatenate([*spectra]), [0.25, 0.5], axis=0)
    steady: NDArray[np.bool_] = low > _STEADY * median
    return steady


def _spectrum(samples: Array) -> Array:
    """Amplitude spectrum of samples along their last axis, with a Hann window."""
    amplitudes: Array = np.abs(np.fft.rfft(samples * np.hanning(samples.shape[-1] + 1)[:-1]))
    return amplitudes


_SPIKE = 20.0
"""A spike is farther from the median than this multiple of the range from the 1 % to the 99 % quantile."""
_PILE = 3
"""Clipping needs more than this ratio of samples at the limit to samples at the next value. Coarse
quantization has a smaller ratio."""
Ranges = Mapping[Channel, tuple[float, float]]
"""Lowest and highest plausible value, in the unit of the channel."""


def defects(recording: Record, limits: RemarkLimits, ranges: Ranges) -> Iterator[Issue]:
    """Remarks on a record and on each of its channels, and on values outside of `ranges`."""
    if limits.samples is not None and recording.n_time != limits.samples:
        text = f"has {counted(recording.n_time, 'sample')} instead of {limits.samples}"
        yield Issue(text, kind="wrong_length")
    channels = {channel: samples for channel, (samples,) in recording.channels.items()}
    yield from _unusual_sizes(recording, channels)
    for channel in channels:
        yield from _of_channel(recording, channel, channels, limits, ranges)


def _of_channel(
    recording: Record,
    channel: Channel,
    channels: Mapping[Channel, Array],
    limits: RemarkLimits,
    ranges: Ranges,
) -> Iterator[Issue]:
    samples = channels[channel]
    missing = np.flatnonzero(~np.isfinite(samples))
    if missing.size and any(remark.kind == "gap" for remark in recording.remarks[0]):
        return  # said of the record
    if missing.size:
        first, last = recording.start_time + missing[[0, -1]] / recording.sampling_frequency
        text = (
            f"{missing.size} of {counted(samples.size, 'sample')} of {channel} are missing or not finite"
            f" ({first:.6g} to {last:.6g} s); to use the rest, set 'trim' or 'cycles' in a description, or"
            " judge windows"
        )
        yield Issue(text, channel, kind="missing", is_unusable=True)
        return
    if channel in ranges:
        yield from _out_of_range(recording, channel, samples, ranges[channel])
    if channel is Channel.OIL_TEMPERATURE:
        return
    frequency = recording.sampling_frequency
    if channel is Channel.PISTON_POSITION and (text := frozen(channels, frequency)):
        yield Issue(text, channel, kind="stuck", is_unusable=True)
        return
    if (stretch := frozen_stretch(channel, channels, frequency)) is not None:
        begin, end = (recording.start_time + index / frequency for index in (stretch.start, stretch.stop))
        text = f"{channel} does not change from {begin:.6g} to {end:.6g} s, but does otherwise"
        yield Issue(text, channel, kind="stuck", is_unusable=True)
        return
    if rate := update_rate(samples, np.arange(samples.size) / frequency):
        text = f"{channel} is updated at {rate:.3g} Hz, not {frequency:g} Hz: nothing above {rate / 2:.3g} Hz"
        yield Issue(text, channel, kind="held")
    if np.ptp(samples) == 0.0:
        is_dead = channel is Channel.SUPPLY_PRESSURE and samples[0] <= 0.0
        if is_dead or channel not in _RAILS:
            is_unusable = is_dead or must_change(channel)
            yield Issue(f"{channel} never changes", channel, kind="stuck", is_unusable=is_unusable)
        return
    if channel is not Channel.INPUT_VOLTAGE:
        yield from _spikes(recording, channel, samples)
    if channel.is_pressure:
        yield from _clipped(recording, channel, samples, limits.clipped)
    yield from _hum(recording, channel, samples, limits)


def _out_of_range(
    recording: Record, channel: Channel, samples: Array, limits: tuple[float, float]
) -> Iterator[Issue]:
    rounding = 1e-9 * (limits[1] - limits[0])
    outside = float(np.mean((samples < limits[0] - rounding) | (samples > limits[1] + rounding)))
    if outside:
        low, high = (recording.shown(channel, limit) for limit in limits)
        text = f"{outside:.2%} of {channel} samples lie outside its range, {low} … {high}"
        yield Issue(text, channel, kind="out_of_range")


def _spikes(recording: Record, channel: Channel, samples: Array) -> Iterator[Issue]:
    low, middle, high = np.quantile(samples, [0.01, 0.5, 0.99])
    away = np.abs(samples - middle)
    n_far = int(np.count_nonzero(away > ABOVE * _SPIKE * (high - low)))
    if n_far and n_far < samples.size / 100:
        farthest = int(np.argmax(away))
        value = recording.shown(channel, float(samples[farthest]))
        text = f"implausible samples of {channel}: {n_far}, such as {value} at sample {farthest + 1}"
        yield Issue(text, channel, kind="spike")


def _clipped(recording: Record, channel: Channel, samples: Array, limit: float) -> Iterator[Issue]:
    for kind, end, sign in (("clipped", "lowest", 1.0), ("saturated", "highest", -1.0)):
        extreme = sign * np.min(sign * samples)
        n_extreme = int(np.count_nonzero(samples == extreme))
        share = n_extreme / samples.size
        others = sign * samples[samples != extreme]
        if share > limit and n_extreme > _PILE * np.count_nonzero(others == others.min()):
            value = recording.shown(channel, float(extreme))
            text = f"{share:.1%} of {channel} samples lie at the {end} value, {value}"
            yield Issue(text, channel, kind=kind)


def _hum(recording: Record, channel: Channel, samples: Array, limits: RemarkLimits) -> Iterator[Issue]:
    shares = {mains: hum_share(samples, recording.sampling_frequency, mains) for mains in limits.mains}
    mains = max(shares, key=shares.__getitem__)
    if shares[mains] > limits.hum:
        text = f"{shares[mains]:.0%} of the power of {channel} above 20 Hz is hum of {mains:g} Hz"
        yield Issue(text, channel, kind="hum")


_TOLERANCE = 0.01


def differences(recording: Record, first: Record) -> Iterator[Issue]:
    """Remarks if the sampling, or a header's unit under a gain, differs from the first record."""
    frequency, usual = recording.sampling_frequency, first.sampling_frequency
    if abs(frequency / usual - 1.0) > _TOLERANCE:
        text = f"sampled at {frequency:g} Hz, the first record at {usual:g} Hz: bands of d1, d2, … differ"
        yield Issue(text, kind="sampling_varies")
    for channel, header in recording.headers.items():
        before = first.headers.get(channel, header)
        if header != before:
            text = f"one gain for headers in {header or 'no unit'} and, in record 1, {before or 'no unit'}"
            yield Issue(text, channel, kind="units_vary")


_LOWEST_PRESSURE = 1e5
"""A running hydraulic machine has some pressure above this [Pa]; a chamber at tank pressure may be below."""
_LIKELY_UNITS = ((60.0, "MPa or bar"), (600.0, "bar"), (10e3, "psi"), (_LOWEST_PRESSURE, "kPa"))
"""Upper limit of the values → their probable unit."""

_USUAL = {
    Channel.CHAMBER_1_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.CHAMBER_2_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.SUPPLY_PRESSURE: usual.SUPPLY_PRESSURE,
    Channel.RETURN_PRESSURE: usual.RETURN_PRESSURE,
    Channel.PISTON_POSITION: usual.POSITION,
    Channel.SPOOL_POSITION: usual.SPOOL_POSITION,
    Channel.INPUT_VOLTAGE: usual.VOLTAGE,
}
_USUAL_IN_SI = {name: [parse_quantity(each, name.unit) for each in sizes] for name, sizes in _USUAL.items()}
_MOST_RATIO = 5.0
"""Ratio of the mean chamber pressures above which one of them may have another unit; pressures that are alike
differ by about ten if one is in bar and read as MPa."""


def _unusual_sizes(recording: Record, channels: Mapping[Channel, Array]) -> Iterator[Issue]:
    """Remarks on channels beyond the usual sizes, on pressures of which none reaches 0.1 MPa, and on chamber
    pressures that are not alike."""
    channels = {
        channel: samples
        for channel, samples in channels.items()
        if channel not in recording.relative and np.all(np.isfinite(samples))
    }
    loaded = [name for name in channels if name.is_pressure and name is not Channel.RETURN_PRESSURE]
    highest = {channel: float(np.max(channels[channel])) for channel in loaded}
    for name, value in highest.items() if max(highest.values(), default=0.0) < _LOWEST_PRESSURE else ():
        unit = next(unit for most, unit in _LIKELY_UNITS if value < most)
        text = f"{name}: values up to {value:.4g} Pa; is the unit {unit}? Hydraulic pressures exceed 0.1 MPa"
        yield Issue(text, name, kind="low_pressure")
    for channel in (name for name in _USUAL if name in channels):
        low, high = _USUAL_IN_SI[channel]
        largest = float(np.max(np.abs(channels[channel])))
        if largest > high or (0.0 < largest < low and not channel.is_pressure):
            text = f"{channel}: values up to {recording.shown(channel, largest)} are far"
            sides = "above" if largest > high else "below"
            yield Issue(f"{text} {sides} the usual {' … '.join(_USUAL[channel])}", channel, kind="unusual")
    chambers = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE
    means = {channel: float(np.mean(channels[channel])) for channel in chambers if channel in channels}
    if len(means) == 2 and max(means.values()) > _MOST_RATIO * abs(min(means.values())):
        larger, smaller = sorted(means, key=means.__getitem__, reverse=True)
        shown = [recording.shown(channel, means[channel]) for channel in (larger, smaller)]
        text = f"{larger}: the mean is {shown[0]}, but {shown[1]} of {smaller}; is a unit or gain wrong?"
        yield Issue(text, larger, kind="unusual")


_RATE = 0.01
"""Share of the sampling frequency by which the mean rate of a window may differ."""


def fault_of(
    time: Array, samples: Array, channels: tuple[Channel, ...], n_sample: int, sampling_frequency: float
) -> Issue | None:
    """The first fault of a window, in the order: length, rate, steps, missing samples, stuck channels."""
    n_time = time.size
    if n_time < n_sample:
        return Issue(f"the cycle has {counted(n_time, 'sample')} instead of {n_sample}", kind="short_cycle")
    rate = (n_time - 1) / float(time[-1] - time[0]) if n_time > 1 else sampling_frequency
    if abs(rate - sampling_frequency) > _RATE * sampling_frequency:
        text = f"samples come at {rate:.4g} Hz instead of {sampling_frequency:.4g} Hz"
        return Issue(text + other_unit(1.0 / rate, 1.0 / sampling_frequency), kind="other_rate")
    if text := uneven_window(time):
        return Issue(text, kind="uneven")
    lows, highs = samples.min(axis=1), samples.max(axis=1)
    for row in np.flatnonzero(~(np.isfinite(lows) & np.isfinite(highs))):
        n_missing = int(np.count_nonzero(~np.isfinite(samples[row])))
        if n_missing == n_time:
            return Issue(f"{channels[row]} is missing", kind="missing_channel")
        text = f"{n_missing} of {counted(n_time, 'sample')} of {channels[row]} are missing or not finite"
        return Issue(text, kind="missing")
    for row in np.flatnonzero(lows == highs):
        if must_change(channels[row]):
            return Issue(f"{channels[row]} never changes", kind="stuck")
    text = frozen(dict(zip(channels, samples, strict=True)), sampling_frequency)
    return Issue(text, kind="stuck") if text else None
