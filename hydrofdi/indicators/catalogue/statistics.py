"""Statistics of a pressure, and cross-correlation of the two chamber pressures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.single_channel import ChannelOptions, SingleChannelIndicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section


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
        place = np.argmax(height >= (1.0 - 1e-12) * height.max(axis=1, keepdims=True), axis=1)
        peak = covariance[np.arange(records.n_record), place]
        moves = np.where(size > 0.0, 1.0, np.nan)
        return {
            "coefficient": covariance[:, lag] / size,
            "peak_coefficient": peak / size,
            "peak": moves * np.copysign(np.sqrt(np.abs(peak)), peak),
            "lag": moves * (place - lag) / records.sampling_frequency,
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
