"""A file cut into the parts that become records: trimmed, divided into cycles, one segment of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from hydrofdi.errors import Issue
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import CyclesConfig, SegmentConfig, TrimConfig
from hydrofdi.records.measured.parts.events import edges, reversals
from hydrofdi.records.measured.parts.stroke import Stroke
from hydrofdi.records.measured.recording import Recording
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.records.measured.sampling import Sampling


def part(recording: Recording, first: int, stop: int, start_time: float | None = None) -> Recording:
    """The samples from `first` to before `stop`; time continues unless `start_time` is given."""
    sampling = recording.sampling
    start = sampling.start + first / sampling.frequency if start_time is None else start_time
    return replace(
        recording,
        channels={channel: samples[first:stop] for channel, samples in recording.channels.items()},
        sampling=Sampling(sampling.frequency, start),
    )


def trimmed(recording: Recording, trim: TrimConfig) -> Recording:
    """The recording without its trimmed ends.

    Raises
    ------
    RejectionError
        Nothing is left.
    """
    frequency, n_time = recording.sampling.frequency, recording.n_time
    first, stop = _samples(trim.start, frequency), n_time - _samples(trim.end, frequency)
    if stop - first < 2:
        raise RejectionError("short", f"lasts {n_time / frequency:g} s; nothing is left after trimming")
    return recording if (first, stop) == (0, n_time) else part(recording, first, stop)


def cycles_of(recording: Recording, cycles: CyclesConfig) -> Iterator[Recording | RejectionError]:
    """The cycles of a file, each with its own time zero; a remark states the time outside of them.

    Raises
    ------
    RejectionError
        There is no complete cycle.
    """
    spans = _spans(recording, cycles)
    if not spans:
        raise RejectionError("no_cycle", f"contains no complete cycle by {cycles.by}")
    left_out = _left_out(recording, spans)
    for number, (first, stop) in enumerate(spans):
        cycle = part(recording, first, stop, start_time=0.0)
        cycle = replace(cycle, remarks=(*cycle.remarks, *left_out)) if number == 0 else cycle
        try:
            yield of_length(cycle, cycles.length, "the cycle")
        except RejectionError as rejection:
            yield rejection


def segment_of(recording: Recording, stroke: Stroke | None, segment: SegmentConfig) -> Recording:
    """The requested part of a stroke.

    Raises
    ------
    RejectionError
        The piston does not move, or the part is too short.
    """
    if stroke is None:
        raise RejectionError("no_motion", "the piston does not move")
    first, stop = _segment_span(stroke, segment, recording)
    if first < 0 or stop - first < 2:
        raise RejectionError("short", f"contains no {segment.part} of the stroke")
    return of_length(part(recording, first, stop, start_time=0.0), segment.length, f"the {segment.part}")


def of_length(recording: Recording, length: float | None, what: str) -> Recording:
    """The first part of a recording, of the requested length [s].

    Raises
    ------
    RejectionError
        It is shorter.
    """
    frequency = recording.sampling.frequency
    n_time = recording.n_time if length is None else _samples(length, frequency)
    if not 2 <= n_time <= recording.n_time:
        lasts = recording.n_time / frequency
        raise RejectionError("short", f"{what} lasts {lasts:g} s; the description requires {length or 0:g} s")
    return recording if n_time == recording.n_time else part(recording, 0, n_time, recording.sampling.start)


def _samples(duration: float, frequency: float) -> int:
    return round(min(duration * frequency, 1e15))


def _spans(recording: Recording, cycles: CyclesConfig) -> list[tuple[int, int]]:
    if cycles.by == "period":
        assert cycles.period is not None
        per_cycle = cycles.period * recording.sampling.frequency
        n_cycle = int((recording.n_time + 1e-6) / per_cycle) if per_cycle >= 2.0 else 0
        starts = [round(number * per_cycle) for number in range(n_cycle)]
        return [(start, start + int(per_cycle + 1e-6)) for start in starts]
    if cycles.by == "edges":
        found = edges(recording.channels[cycles.channel], cycles.edge)
    else:
        found = reversals(recording.channels[Channel.PISTON_POSITION])
    return list(pairwise(found))


def _left_out(recording: Recording, spans: list[tuple[int, int]]) -> tuple[Issue, ...]:
    before, after = spans[0][0], recording.n_time - spans[-1][1]
    if not before + after:
        return ()
    durations = [n / recording.sampling.frequency for n in (before, after)]
    text = f"{durations[0]:g} s before the first cycle and {durations[1]:g} s after the last are left out"
    return (Issue(text, kind="left_out"),)


def _segment_span(stroke: Stroke, segment: SegmentConfig, recording: Recording) -> tuple[int, int]:
    frequency = recording.sampling.frequency
    match segment.part:
        case "motion":
            return stroke.start, stroke.arrival
        case "impact":
            return stroke.arrival - _samples(segment.before, frequency), recording.n_time
        case "hold":
            return stroke.arrival + _samples(segment.settle, frequency), recording.n_time
