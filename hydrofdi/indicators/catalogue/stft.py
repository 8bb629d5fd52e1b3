"""The strongest frequency of a band over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import (
    Band,
    ChannelOptions,
    SegmentTime,
    SingleChannelIndicator,
    band_obstacle,
    middle_band,
    segment_obstacle,
)
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.ridge import spectral_ridge


class StftOptions(ChannelOptions):
    """Options of `Stft`."""

    band: Band | None = None
    """Band searched for the strongest frequency [Hz]; by default a sixteenth to a quarter of the sampling
    frequency."""

    segment: SegmentTime = 0.25
    """Length of the segments [s]; they overlap by half."""


class Stft(SingleChannelIndicator[StftOptions]):
    """Frequency and amplitude of the ridge of a short-time Fourier transform."""

    name = "stft"
    version = 1
    summary = "The strongest frequency of a band over time, and its amplitude: mean and spread."
    source = "Allen, IEEE Trans. Acoust. Speech Signal Process. 25(3) (1977) 235"
    equation = "f(t) = argmax over the band of |X(t, f)|, A(t) = |X(t, f(t))|; mean of f weighted by A²"
    Options = StftOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Mean and standard deviation over the segments."""
        return (
            Output("frequency", "Hz", "strongest frequency, power-weighted mean"),
            Output(
                "frequency_spread",
                "Hz",
                "power-weighted standard deviation of the strongest frequency over time",
            ),
            Output("amplitude", self.unit, "amplitude of the strongest frequency, mean over time"),
            Output("amplitude_spread", self.unit, "standard deviation of the amplitude over time"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the band contains no line of the transform, or if the segment does not fit."""
        frequency, segment = records.sampling_frequency, self.options.segment
        band = middle_band(self.options.band, frequency)
        reason = band_obstacle(records, band) or segment_obstacle(records, segment)
        if reason is None and band[1] - band[0] < 2.0 / segment:
            return f"a band of {band[1] - band[0]:g} Hz needs segments of {2.0 / (band[1] - band[0]):.3g} s"
        return reason

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); frequencies are NaN if the signal is constant."""
        sampling = records.sampling_frequency
        band, n_segment = middle_band(self.options.band, sampling), round(self.options.segment * sampling)
        frequency, amplitude = spectral_ridge(self.signal(records), sampling, band, n_segment, n_segment // 2)
        power = np.square(amplitude)
        total = np.sum(power, axis=-1)
        mean = np.sum(power * frequency, axis=-1) / total
        variance = np.sum(power * np.square(frequency - mean[:, None]), axis=-1) / total
        return {
            "frequency": mean,
            "frequency_spread": np.sqrt(variance),
            "amplitude": np.mean(amplitude, axis=-1),
            "amplitude_spread": np.std(amplitude, axis=-1),
        }
