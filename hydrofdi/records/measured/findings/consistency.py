"""Records of one source that were not recorded alike."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.errors import Issue
from hydrofdi.records.measured.recording import Recording

_TOLERANCE = 0.01


def differences(recording: Recording, first: Recording) -> Iterator[Issue]:
    """Remarks if the sampling, or a header's unit under a gain, differs from the first record."""
    found, usual = recording.sampling.frequency, first.sampling.frequency
    if abs(found / usual - 1.0) > _TOLERANCE:
        text = f"sampled at {found:g} Hz, the first record at {usual:g} Hz: bands of d1, d2, … differ"
        yield Issue(text, kind="sampling_varies")
    for channel, header in recording.scaled_headers.items():
        before = first.scaled_headers.get(channel, header)
        if header != before:
            text = f"one gain for headers in {header or 'no unit'} and, in record 1, {before or 'no unit'}"
            yield Issue(text, channel, kind="units_vary")
