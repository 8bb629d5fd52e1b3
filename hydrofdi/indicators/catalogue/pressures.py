"""Pressures without a model: statistics, cross-correlation, and decay while the actuator is at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import ChannelOptions, Indicator, Output, SingleChannelIndicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import ABOVE, SI, Section


class PressureStatistics(SingleChannelIndicator[ChannelOptions]):
    """Mean, standard deviation, increments, kurtosis, crest factor and peak to peak of a channel."""

    name = "pressure_statistics"
    version = 1
    source = "Dyer and Stewart, J. Mech. Des. 100 (1978) 229: kurtosis for condition monitoring"
    equation = "x = P − mean; s² = mean(x²); kurtosis = mean(x⁴)/s⁴; crest = max abs(x)/s"
    Options = ChannelOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Outputs in the unit of the channel, or dimensionless."""
        return (
            Output("mean", self.unit, "mean"),
            Output("standard_deviation", self.unit, "standard deviation"),
            Output("increments", self.unit, "standard deviation of the differences between adjacent samples"),
            Output("kurtosis", "1", "kurtosis: 3 for a normal distribution, 1 for a square wave"),
            Output("crest_factor", "1", "largest deviation from the mean over the standard deviation"),
            Output("peak_to_peak", self.unit, "largest minus smallest sample"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record has only one sample."""
        return "statistics need at least two samples" if records.n_time < 2 else None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); kurtosis and crest factor are NaN if the signal is constant."""
        signal = self.signal(records)
        moved = signal - signal[:, :1]
        offset = moved.mean(axis=1)
        increments = np.diff(moved, axis=1)
        moved -= offset[:, None]
        square = np.square(moved)
        variance = square.mean(axis=1)
        deviation, low, high = np.sqrt(variance), moved.min(axis=1), moved.max(axis=1)
        increments -= increments.mean(axis=1)[:, None]
        return {
            "mean": signal[:, 0] + offset,
            "standard_deviation": deviation,
            "increments": np.sqrt(np.mean(np.square(increments), axis=1)),
            "kurtosis": np.mean(np.square(square), axis=1) / variance**2,
            "crest_factor": np.maximum(-low, high) / deviation,
            "peak_to_peak": high - low,
        }


_CHAMBERS = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE


class CrossCorrelationOptions(Section):
    """Options of `CrossCorrelation`."""

    largest_lag: Annotated[float, SI("s", least=0)] = 0.1
    """Largest lag considered [s]."""


class CrossCorrelation(Indicator[CrossCorrelationOptions]):
    """Correlation coefficient of the chamber pressures; peak and lag of their cross-covariance."""

    name = "cross_correlation"
    version = 1
    source = (
        "ASME/BATH Symposium on Fluid Power and Motion Control, FPMC2014, paper V001T01A003; only its"
        " abstract was available"
    )
    equation = "c(τ) = mean(p_1(t) p_2(t + τ)), p: P minus its mean; peak: largest abs(c)"
    absence = "a chamber pressure is constant"
    Options = CrossCorrelationOptions

    channels = frozenset(_CHAMBERS)
    outputs = (
        Output("coefficient", "1", "correlation coefficient at zero lag"),
        Output("peak_coefficient", "1", "correlation coefficient at the peak"),
        Output("peak", "Pa", "signed square root of the cross-covariance at its peak"),
        Output("lag", "s", "lag of chamber 2 behind chamber 1 at the peak"),
    )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the record is not longer than the lags."""
        if self._lag(records) >= records.n_time:
            return f"{records.n_time} samples are too few for lags of {self.options.largest_lag:g} s"
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """NaN if a pressure is constant."""
        first, second = (_centred(records[channel]) for channel in _CHAMBERS)
        size = np.sqrt(np.mean(np.square(first), axis=1) * np.mean(np.square(second), axis=1))
        lag = self._lag(records)
        covariance = _cross_covariance(first, second, lag)
        # of equal peaks, the earliest
        height = np.abs(covariance)
        index = np.argmax(height >= (1.0 - 1e-12) * height.max(axis=1, keepdims=True), axis=1)
        peak = covariance[np.arange(records.n_record), index]
        moves = np.where(size > 0.0, 1.0, np.nan)
        return {
            "coefficient": covariance[:, lag] / size,
            "peak_coefficient": peak / size,
            "peak": moves * np.copysign(np.sqrt(np.abs(peak)), peak),
            "lag": moves * (index - lag) / records.sampling_frequency,
        }

    def _lag(self, records: RecordBatch) -> int:
        return round(self.options.largest_lag * records.sampling_frequency)


def _centred(signal: Array) -> Array:
    moved = signal - signal[:, :1]
    centred: Array = moved - moved.mean(axis=1)[:, None]
    return centred


def _cross_covariance(first: Array, second: Array, lag: int) -> Array:
    """Mean of first(t) second(t + τ) for τ = −lag … lag samples, shape (n_record, 2 lag + 1)."""
    from scipy.fft import irfft, next_fast_len, rfft

    n_time = first.shape[1]
    n_padded = next_fast_len(n_time + lag, real=True)
    spectrum = np.conj(rfft(first, n_padded, axis=1)) * rfft(second, n_padded, axis=1)
    circular = irfft(spectrum, n_padded, axis=1) / n_time
    covariance: Array = np.concatenate((circular[:, n_padded - lag :], circular[:, : lag + 1]), axis=1)
    return covariance


Places = NDArray[np.intp]


@dataclass(frozen=True)
class Stretches:
    """Stretches of records, and their samples, concatenated.

    For each stretch the row of the `record`, index of its `first` sample, and `length`; for each sample its
    flat index (`places`) in an array (n_record, n_time), and `time` from the middle of the stretch [samples].
    """

    record: Places
    first: Places
    length: Places
    places: Places
    time: Array

    def means(self, signal: Array) -> Array:
        """Mean of a signal (n_record, n_time) in each stretch, shape (n_stretch,)."""
        return self._sums(signal.reshape(-1)[self.places]) / self.length

    def n_sample(self, n_record: int) -> Array:
        """Number of samples in stretches, for each record, shape (n_record,)."""
        return np.bincount(self.record, self.length, n_record).astype(np.float64)

    def drifts(self, signal: Array, signs: Array | None = None) -> Array:
        """Least-squares slope per sample of a signal, common to all stretches of a record: (n_record,).

        `signs` (n_stretch,) multiply the signal in each stretch; NaN if a record has no stretch.
        """
        samples = signal.reshape(-1)[self.places]
        # Less the first sample of each stretch, so that the products do not cancel large means.
        samples -= np.repeat(samples[self.first], self.length)
        samples *= self.time
        products, squares = self._sums(samples), self.length * (np.square(self.length) - 1.0) / 12.0
        if signs is not None:
            products *= signs
        slopes: Array = np.bincount(self.record, products, len(signal)) / np.bincount(
            self.record, squares, len(signal)
        )
        return slopes

    def drift_errors(self, signal: Array, slopes: Array) -> Array:
        """Standard deviations of `drifts` from their residuals, which are taken as white noise."""
        left = signal.reshape(-1)[self.places] - np.repeat(self.means(signal), self.length)
        left -= np.repeat(slopes[self.record], self.length) * self.time
        squares = np.bincount(self.record, self.length * (np.square(self.length) - 1.0) / 12.0, len(signal))
        free = self.n_sample(len(signal)) - np.bincount(self.record, minlength=len(signal)) - 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            left_squares = np.bincount(self.record, self._sums(np.square(left)), len(signal))
            return np.sqrt(left_squares / np.maximum(free, 1.0) / squares)

    def _sums(self, samples: Array) -> Array:
        sums: Array = np.add.reduceat(samples, self.first) if self.first.size else np.zeros(0)
        return sums


def stretches_where(holds: NDArray[np.bool_], settling: int, least: int) -> Stretches:
    """Find the stretches in which a condition (n_record, n_time) holds, after `settling` samples.

    Those with fewer than `least` remaining samples, at least 2, are excluded.
    """
    n_record, n_time = holds.shape
    framed = np.zeros((n_record, n_time + 2), dtype=bool)
    framed[:, 1:-1] = holds
    row, edge = np.divmod(np.flatnonzero(framed[:, 1:] != framed[:, :-1]), n_time + 1)
    record, start, length = row[::2], edge[::2] + settling, edge[1::2] - edge[::2] - settling
    long = length >= least
    record, start, length = record[long], start[long], length[long]
    first = np.cumsum(length) - length
    within = np.arange(length.sum()) - np.repeat(first, length)
    return Stretches(
        record=record,
        first=first,
        length=length,
        places=within + np.repeat(record * n_time + start, length),
        time=within - np.repeat(0.5 * (length - 1.0), length),
    )


_P1, _P2 = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE
_SHOWN_BY = {"command": Channel.INPUT_VOLTAGE, "position": Channel.PISTON_POSITION}


class PressureDecayOptions(Section):
    """Options of `PressureDecay`."""

    rest: Literal["auto", "command", "position", "whole"] = "auto"
    """Definition of rest. ``command``: the input voltage is zero; it must be in volts. ``position``: the
    piston does not move. ``auto``: the first of these that is available. ``whole``: the whole record, for
    rest tests."""

    largest_command: Annotated[float, SI("V", least=0)] = 0.02
    """Largest input voltage that counts as zero [V]."""

    largest_speed: Annotated[float, SI("m/s", least=0)] = 1e-3
    """Largest mean speed over ``speed_time`` at which the piston counts as at rest [m/s]."""

    largest_relative_speed: Annotated[float, SI("1/s", least=0)] = 0.02
    """The same, relative to the range of the position in the record [1/s], for a position in counts."""

    speed_time: Annotated[float, SI("s", above=0)] = 0.1
    """Averaging time of the speed [s]."""

    settling: Annotated[float, SI("s", least=0)] = 0.2
    """Time excluded at the start of each rest [s]."""

    least_duration: Annotated[float, SI("s", above=0)] = 0.2
    """Minimum duration of a rest after settling [s]."""

    enclosed_volume: Annotated[float, SI("m^3", above=0)] | None = None
    """Volume of fluid that the closed valve encloses with the gauge of chamber 1, hoses included [m³]. With
    it, the leak out of this volume is stated as a flow."""

    volume_deviation: Annotated[float, SI("1", least=0)] = 0.05
    """Relative standard deviation of this volume [-]."""

    bulk_modulus: Annotated[float, SI("Pa", least=1e4, most=1e11)] = 1e9
    """Effective bulk modulus β of fluid and walls at the pressure of the test [Pa]; of a gas n·P, with n = 1
    if it is slow."""

    bulk_modulus_deviation: Annotated[float, SI("1", least=0)] = 0.3
    """Relative standard deviation of β [-]."""


class PressureDecay(Indicator[PressureDecayOptions]):
    """Rates of change of the chamber pressures, and of the magnitude of their difference, while the
    actuator rests.
    """

    name = "pressure_decay"
    version = 1
    source = (
        "EN 1779 (1999), leak testing by pressure change; least squares over the rests is specific to"
        " hydrofdi"
    )
    equation = "dP/dt: common slope of all rests; dP_1/dt = −(β/V) q with piston at rest and valve closed"
    caution = (
        "Enclosed oil that cools by 0.1 K shrinks by 0.007 %, which looks like a leak of as much: wait until"
        " temperatures are even."
    )
    absence = "no rest is long enough"
    Options = PressureDecayOptions

    @property
    def channels(self) -> frozenset[Channel]:
        """The pressure of chamber 1, and the channel that ``rest`` names."""
        return frozenset({_P1, _SHOWN_BY.get(self.options.rest, _P1)})

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """The other pressure, and channels that may show the rests."""
        return frozenset({_P2, *(_SHOWN_BY.values() if self.options.rest == "auto" else ())})

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Rates; with an enclosed volume the leak out of it, too."""
        rate, rising = "rate of change of the {} at rest", Direction.RISING
        difference = rate.format("magnitude of the pressure difference")
        rates = (
            Output("chamber_1", "Pa/s", rate.format("chamber-1 pressure")),
            Output("chamber_2", "Pa/s", rate.format("chamber-2 pressure")),
            Output("difference", "Pa/s", difference, direction=Direction.FALLING),
            Output.quality("duration", "s", "time at rest that was used"),
        )
        if self.options.enclosed_volume is None:
            return rates
        text = "leak out of the enclosed volume"
        leak = Output("leak", "m^3/s", text, direction=rising, error="leak_error")
        return (*rates, leak, Output.quality("leak_error", "m^3/s", "standard deviation of this leak"))

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the rests cannot be found."""
        if self.options.rest == "command" and Channel.INPUT_VOLTAGE in records.relative:
            return "input_voltage has no scale, so its zero is unknown"
        if self._shown_by(records) is None:
            return (
                "without input_voltage or piston_position, rests cannot be found; rest: whole uses the"
                " whole record"
            )
        return None

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Rates [Pa/s] and leak [m³/s], each (n_record,); NaN without a rest or the pressure."""
        frequency, options = records.sampling_frequency, self.options
        rests = stretches_where(
            self._is_resting(records),
            round(options.settling * frequency),
            max(2, round(options.least_duration * frequency)),
        )
        first = records[_P1]
        second = records[_P2] if _P2 in records.channels else np.full_like(first, np.nan)
        difference = first - second
        duration = rests.n_sample(records.n_record) / frequency
        signs = np.sign(rests.means(difference))
        slopes = rests.drifts(first)
        values = {
            "chamber_1": frequency * slopes,
            "chamber_2": frequency * rests.drifts(second),
            "difference": frequency * rests.drifts(difference, signs),
            "duration": np.where(duration > 0.0, duration, np.nan),
        }
        if options.enclosed_volume is not None:
            compliance = options.enclosed_volume / options.bulk_modulus
            noise = compliance * frequency * rests.drift_errors(first, slopes)
            values["leak"] = -compliance * values["chamber_1"]
            share = math.hypot(options.volume_deviation, options.bulk_modulus_deviation)
            values["leak_error"] = np.hypot(noise, share * values["leak"])
        return values

    def _shown_by(self, records: RecordBatch) -> str | None:
        if self.options.rest != "auto":
            return self.options.rest
        known = records.channels.keys() - (records.relative & {Channel.INPUT_VOLTAGE})
        return next((name for name, channel in _SHOWN_BY.items() if channel in known), None)

    def _is_resting(self, records: RecordBatch) -> NDArray[np.bool_]:
        """Whether the command is zero, or the piston moved little over the last ``speed_time``."""
        options, frequency = self.options, records.sampling_frequency
        shape = records.n_record, records.n_time
        resting, shown_by = np.ones(shape, dtype=bool), self._shown_by(records)
        if shown_by == "command":
            resting = np.abs(records[Channel.INPUT_VOLTAGE]) <= ABOVE * options.largest_command
        elif shown_by == "position":
            position = records[Channel.PISTON_POSITION]
            largest = np.full(records.n_record, options.largest_speed)
            if Channel.PISTON_POSITION in records.relative:
                largest = options.largest_relative_speed * np.ptp(position, axis=1)
            lag = max(1, round(options.speed_time * frequency))
            moved = np.abs(position[:, lag:] - position[:, : max(records.n_time - lag, 0)])
            resting[:, :lag] = False
            resting[:, lag:] = moved <= ABOVE * largest[:, None] * lag / frequency
        return resting
