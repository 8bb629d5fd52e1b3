"""Options of indicators that look at bands of frequency, and what keeps a record from being measured."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

from hydrofdi.records import RecordBatch
from hydrofdi.settings.quantities import SI

_FEWEST_SAMPLES = 8
"""Of a segment."""


def _rising(band: tuple[float, float]) -> tuple[float, float]:
    if not band[0] < band[1]:
        raise ValueError(f"a band goes from its lowest to its highest frequency; found {list(band)} Hz")
    return band


Frequency = Annotated[float, SI("Hz", least=0)]
"""[Hz]"""

Band = Annotated[tuple[Frequency, Frequency], AfterValidator(_rising)]
"""Lowest and highest frequency [Hz]."""

SegmentTime = Annotated[float, SI("s", above=0)]
"""Length of a segment [s]."""


def middle_band(band: Band | None, sampling_frequency: float) -> Band:
    """A band; from a sixteenth to a quarter of the sampling frequency where none is given [Hz]."""
    return (sampling_frequency / 16, sampling_frequency / 4) if band is None else band


def band_obstacle(records: RecordBatch, band: Band) -> str | None:
    """A band that ends above half of the sampling frequency."""
    highest = records.sampling_frequency / 2
    if band[1] > highest:
        return f"a band ends at {band[1]:g} Hz, above half of the sampling frequency, {highest:g} Hz"
    return None


def segment_obstacle(records: RecordBatch, segment: float) -> str | None:
    """A segment that is longer than the record, or of too few samples."""
    samples = round(segment * records.sampling_frequency)
    if samples < _FEWEST_SAMPLES:
        return f"a segment of {segment:g} s has {samples} samples; {_FEWEST_SAMPLES} are needed"
    if samples > records.n_time:
        return f"a segment of {segment:g} s has {samples} samples, the record {records.n_time}"
    return None
