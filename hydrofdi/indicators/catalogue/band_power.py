"""RMS in frequency bands, from Welch's power spectral density."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from hydrofdi.indicators import single_channel
from hydrofdi.indicators.contract import Output
from hydrofdi.records import Array, RecordBatch
from hydrofdi.transforms.spectrum import band_rms
from hydrofdi.transforms.wavelet import level_bands

_OCTAVES = 5


class BandPowerOptions(single_channel.ChannelOptions):
    """Options of `BandPower`."""

    bands: Annotated[tuple[single_channel.Band, ...], Field(min_length=1)] | None = None
    """Bands as pairs of frequencies [Hz]. By default: five octaves down from half of the sampling frequency,
    like the levels of a wavelet transform, and the rest below."""

    segment: single_channel.SegmentTime = 1.0
    """Length of Welch's segments [s]; its inverse is the resolution [Hz]."""


class BandPower(single_channel.SingleChannelIndicator[BandPowerOptions]):
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
        beyond = (single_channel.band_obstacle(records, band) for band in self.options.bands or ())
        return next(filter(None, beyond), None) or single_channel.segment_obstacle(
            records, self.options.segment
        )

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
