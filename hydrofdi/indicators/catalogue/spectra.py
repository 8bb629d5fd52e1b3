"""RMS in frequency bands (band_power), and the strongest frequency of a band over time (stft)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from hydrofdi.indicators.contract import ChannelOptions, Output, SingleChannelIndicator
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms import level_bands

_FEWEST_SAMPLES = 8
"""Least number of samples of a segment."""


def _rising(band: tuple[float, float]) -> tuple[float, float]:
    if not band[0] < band[1]:
        raise ValueError(f"a band must be [lowest, highest] frequency; found {list(band)} Hz")
    return band


Frequency = Annotated[float, SI("Hz", least=0)]
"""[Hz]"""


Band = Annotated[tuple[Frequency, Frequency], AfterValidator(_rising)]
"""Lowest and highest frequency [Hz]."""


SegmentTime = Annotated[float, SI("s", above=0)]
"""Length of a segment [s]."""


def middle_band(band: Band | None, sampling_frequency: float) -> Band:
    """The band, by default from 1/16 to 1/4 of the sampling frequency [Hz]."""
    return (sampling_frequency / 16, sampling_frequency / 4) if band is None else band


def band_obstacle(records: RecordBatch, band: Band) -> str | None:
    """Message if the band ends above half of the sampling frequency, else None."""
    highest = records.sampling_frequency / 2
    if band[1] > highest:
        return f"a band ends at {band[1]:g} Hz, above half of the sampling frequency, {highest:g} Hz"
    return None


def segment_obstacle(records: RecordBatch, segment: float) -> str | None:
    """Message if the segment is longer than the record or has too few samples, else None."""
    samples = round(segment * records.sampling_frequency)
    if samples < _FEWEST_SAMPLES:
        return f"a segment of {segment:g} s has {samples} samples; {_FEWEST_SAMPLES} are needed"
    if samples > records.n_time:
        return f"a segment of {segment:g} s has {samples} samples, but the record only {records.n_time}"
    return None


def power_spectrum(signal: Array, sampling_frequency: float, segment: float = 2.0) -> tuple[Array, Array]:
    """Power spectral density by Welch's method: Hann windows, 50 % overlap, mean of each segment removed.

    Frequencies [Hz] and one-sided density (..., n_frequency), in the square of the signal's unit per Hz. A
    `segment` [s] is at most as long as the record.
    """
    from scipy.signal import welch

    n_segment = min(signal.shape[-1], round(segment * sampling_frequency))
    frequency, density = welch(signal, sampling_frequency, "hann", n_segment)
    return np.asarray(frequency, dtype=float), np.asarray(density, dtype=float)


def band_rms(
    signal: Array, sampling_frequency: float, bands: Sequence[tuple[float, float]], segment: float
) -> Array:
    """RMS (..., n_band) in bands [Hz] of the power spectral density.

    Each spectral line covers the interval halfway to its neighbours, so that contiguous bands contain the
    total power.
    """
    frequency, density = power_spectrum(signal, sampling_frequency, segment)
    half = frequency[1] / 2
    low, high = np.maximum(frequency - half, 0.0), np.minimum(frequency + half, sampling_frequency / 2)
    shares = [np.maximum(np.minimum(high, top) - np.maximum(low, bottom), 0) for bottom, top in bands]
    # A line whose interval is cut at an end still has the power of a whole one.
    weights = [2 * half * share / (high - low) for share in shares]
    return np.stack([np.sqrt(np.sum(density * weight, axis=-1)) for weight in weights], axis=-1)


def short_time_spectra(signal: Array, n_segment: int, hop: int) -> NDArray[np.complex128]:
    """Spectra of Hann-windowed segments, mean removed, scaled to amplitudes of sines.

    Shape (..., n_segments, n_segment // 2 + 1); a segment starts every `hop` samples. All segments are
    transformed at once; `scipy.signal.ShortTimeFFT` transforms them one by one and takes three to ten times
    as long.
    """
    from scipy.signal import get_window

    window = get_window("hann", n_segment)
    segments = np.lib.stride_tricks.sliding_window_view(signal, n_segment, axis=-1)[..., ::hop, :]
    # Half of a sine's amplitude is at the negative frequency, hence 2.
    segments = (segments - segments.mean(axis=-1, keepdims=True)) * (window * (2.0 / window.sum()))
    spectra: NDArray[np.complex128] = np.fft.rfft(segments, axis=-1)
    return spectra


_OCTAVES = 5


class BandPowerOptions(ChannelOptions):
    """Options of `BandPower`."""

    bands: Annotated[tuple[Band, ...], Field(min_length=1)] | None = None
    """Bands as pairs of frequencies [Hz]. By default: five octaves down from half of the sampling frequency,
    like the levels of a wavelet transform, and the rest below."""

    segment: SegmentTime = 1.0
    """Length of Welch's segments [s]; its inverse is the resolution [Hz]."""


class BandPower(SingleChannelIndicator[BandPowerOptions]):
    """RMS in frequency bands, from the power spectrum of overlapping segments."""

    name = "band_power"
    version = 1
    source = "Welch, IEEE Trans. Audio Electroacoust. 15(2) (1967) 70"
    equation = "b_i = sqrt(integral of S(f) over band i); S: one-sided density, Hann windows, half overlap"
    Options = BandPowerOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """b1, b2, …, each with its band."""
        return tuple(
            Output(f"b{number}", self.unit, f"RMS from {text}")
            for number, text in enumerate(self._texts(), 1)
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if a band lies beyond the spectrum or a segment does not fit."""
        beyond = (band_obstacle(records, band) for band in self.options.bands or ())
        return next(filter(None, beyond), None) or segment_obstacle(records, self.options.segment)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """RMS in the unit of the channel, each (n_record,)."""
        frequency = records.sampling_frequency
        bands = self.options.bands or [
            *level_bands(frequency, _OCTAVES),
            (0.0, frequency / 2 ** (_OCTAVES + 1)),
        ]
        rms = band_rms(self.signal(records), frequency, bands, self.options.segment)
        return {f"b{number + 1}": rms[:, number] for number in range(len(bands))}

    def _texts(self) -> list[str]:
        if self.options.bands is not None:
            return [f"{low:g} Hz to {high:g} Hz" for low, high in self.options.bands]
        octaves = [f"f_s/{2 ** (octave + 1)} to f_s/{2**octave}" for octave in range(1, _OCTAVES + 1)]
        return [*octaves, f"0 to f_s/{2 ** (_OCTAVES + 1)}"]


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


class StftOptions(ChannelOptions):
    """Options of `Stft`."""

    band: Band | None = None
    """Band searched for the strongest frequency [Hz]; by default a sixteenth to a quarter of the sampling
    frequency."""

    segment: SegmentTime = 0.25
    """Length of the segments [s]; they overlap by half."""


class Stft(SingleChannelIndicator[StftOptions]):
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
        band = middle_band(self.options.band, frequency)
        reason = band_obstacle(records, band) or segment_obstacle(records, segment)
        if reason is None and band[1] - band[0] < 2.0 / segment - 1e-9:
            return f"a band of {band[1] - band[0]:g} Hz needs segments of {2.0 / (band[1] - band[0]):.3g} s"
        return reason

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); frequencies are NaN if the signal is constant."""
        sampling = records.sampling_frequency
        band, n_segment = (middle_band(self.options.band, sampling), round(self.options.segment * sampling))
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
