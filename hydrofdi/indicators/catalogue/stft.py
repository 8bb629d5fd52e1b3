"""The strongest frequency of a band over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hydrofdi.indicators import single_channel
from hydrofdi.indicators.contract import Output
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.spectrum import short_time_spectra

_ROUNDING = 1e-12
"""Amplitude relative to the largest sample below which a segment counts as constant (rounding)."""


def spectral_ridge(
    signal: Array, sampling_frequency: float, band: tuple[float, float], n_segment: int, hop: int
) -> tuple[Array, Array]:
    """Strongest frequency in a band [Hz] and its amplitude, for each segment: (..., n_segments).

    Both are interpolated between the largest spectral line and its larger neighbour, which is exact for a
    long tone: Grandke, IEEE Trans. Instrum. Meas. 32(2) (1983) 350. The band is at least two lines of the
    spectrum wide; segments of `n_segment` samples start every `hop`. The amplitude is zero if the segment is
    constant.
    """
    spacing = sampling_frequency / n_segment
    first, last = _lines(band, spacing, n_segment // 2)
    spectra = short_time_spectra(signal, n_segment, hop)[..., first - 1 : last + 2]
    rounding = _ROUNDING * np.abs(signal).max(axis=-1)[..., None]
    size = np.maximum(np.abs(spectra), rounding[..., None])
    peak = 1 + np.argmax(size[..., 1:-1], axis=-1)[..., None]
    before, at, after = (np.take_along_axis(size, peak + side, axis=-1)[..., 0] for side in (-1, 0, 1))
    ratio = np.maximum(before, after) / at
    distance = np.clip((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0, 0.5)
    side = np.where(after > before, distance, -distance)
    frequency = np.clip((first - 1 + peak[..., 0] + side) * spacing, *band)
    amplitude = at * (1.0 - np.square(distance)) / np.sinc(distance)
    return frequency, np.where(at > rounding, amplitude, 0.0)


def _lines(band: tuple[float, float], spacing: float, n_line: int) -> tuple[int, int]:
    """First and last spectral line that lie in a band and have a neighbour on either side."""
    first, last = np.ceil(band[0] / spacing - 1e-9), np.floor(band[1] / spacing + 1e-9)
    return max(1, int(first)), min(n_line - 1, int(last))


class StftOptions(single_channel.ChannelOptions):
    """Options of `Stft`."""

    band: single_channel.Band | None = None
    """Band searched for the strongest frequency [Hz]; by default a sixteenth to a quarter of the sampling
    frequency."""

    segment: single_channel.SegmentTime = 0.25
    """Length of the segments [s]; they overlap by half."""


class Stft(single_channel.SingleChannelIndicator[StftOptions]):
    """The strongest frequency of a band over time, and its amplitude: mean and spread."""

    name = "stft"
    version = 1
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
        band = single_channel.middle_band(self.options.band, frequency)
        reason = single_channel.band_obstacle(records, band) or single_channel.segment_obstacle(
            records, segment
        )
        if reason is None and band[1] - band[0] < 2.0 / segment - 1e-9:
            return f"a band of {band[1] - band[0]:g} Hz needs segments of {2.0 / (band[1] - band[0]):.3g} s"
        return reason

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); frequencies are NaN if the signal is constant."""
        sampling = records.sampling_frequency
        band, n_segment = (
            single_channel.middle_band(self.options.band, sampling),
            round(self.options.segment * sampling),
        )
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
