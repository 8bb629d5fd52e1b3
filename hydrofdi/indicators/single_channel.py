"""Indicators of one channel and of frequency bands."""

from __future__ import annotations

from typing import Annotated, TypeVar

from pydantic import AfterValidator

from hydrofdi.indicators.contract import Indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section

_FEWEST_SAMPLES, _FEWEST_OF_MODES = 8, 16
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


def mode_obstacle(records: RecordBatch) -> str | None:
    """Message if records are too short to have modes."""
    if records.n_time < _FEWEST_OF_MODES:
        return f"a record of {records.n_time} samples has no modes; {_FEWEST_OF_MODES} are needed"
    return None


class ChannelOptions(Section):
    """Options of an indicator of one channel."""

    channel: Channel = Channel.CHAMBER_1_PRESSURE
    """Channel to measure."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The measured channel."""
        return frozenset({self.channel})


ChosenChannel = TypeVar("ChosenChannel", bound=ChannelOptions)


class SingleChannelIndicator(Indicator[ChosenChannel]):
    """An indicator that needs one channel, which its options name."""

    @property
    def unit(self) -> str:
        """Unit of the channel."""
        return self.options.channel.unit

    def signal(self, records: RecordBatch) -> Array:
        """Samples of the channel, shape (n_record, n_time)."""
        return records[self.options.channel]
