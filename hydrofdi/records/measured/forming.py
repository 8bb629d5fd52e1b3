"""A measured file → its records, each with a name, a group and findings."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path, PurePath, PurePosixPath

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import Channel, RecordBatch, RejectedRecord
from hydrofdi.records.measured.cutting import (
    Stroke,
    cycles_of,
    find_stroke,
    normalized,
    reference_pressure,
    segment_of,
    short_stroke,
    trimmed,
)
from hydrofdi.records.measured.defects import Ranges, defects
from hydrofdi.records.measured.description.sections import MeasuredConfig
from hydrofdi.records.measured.formats.table import RejectionError, Table
from hydrofdi.records.measured.recording import Recording, read_recording, recording_of

_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
OWN_NAMES = ("folder", "file", "direction")
"""Names that every record has."""


def path_pattern(template: str) -> re.Pattern[str]:
    """The regular expression of a template of paths.

    Raises
    ------
    re.error
        The template is not a regular expression.
    """
    if not template or "(?P<" in template:
        return re.compile(f"(?:{template})$" if template else "")
    pieces = _FIELD.split(template)
    texts, names = [re.escape(piece) for piece in pieces[::2]], pieces[1::2]
    # a name ends where the text behind it first occurs; only the last one may have to look further
    fields = [f"(?P<{name}>[^/](?:(?!{text})[^/])*+)" for name, text in zip(names, texts[1:], strict=True)]
    fields[-1:] = [f"(?P<{name}>[^/]+?)" for name in names[-1:]]
    return re.compile("".join(a + b for a, b in zip(texts, [*fields, ""], strict=True)) + "$")


def names_of_path(place: str, pattern: re.Pattern[str]) -> dict[str, str] | None:
    """Name → value in a path; None if it does not match."""
    match = pattern.search(place)
    if match is None:
        return None
    path = PurePosixPath(place)
    own = {"folder": path.parent.name, "file": path.name}
    return own | {name: value or "" for name, value in match.groupdict().items()}


def fields_of(template: str) -> list[str]:
    """Names in braces in a template."""
    return _FIELD.findall(template)


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with its names replaced."""
    return _FIELD.sub(lambda match: values[match[1]], template)


@dataclass(frozen=True)
class MeasuredRecord:
    """A record that is not yet in a batch.

    Attributes
    ----------
    record_id, source, group, label : str
    recording : Recording
        Its samples and remarks.
    stroke : float
        Last minus first piston position; zero if unknown.
    """

    record_id: str
    source: str
    group: str
    label: str
    recording: Recording
    stroke: float = 0.0

    def remarked(self, remarks: tuple[Issue, ...]) -> MeasuredRecord:
        """The record with more remarks."""
        if not remarks:
            return self
        found = (*self.recording.remarks, *remarks)
        return replace(self, recording=replace(self.recording, remarks=found))


@dataclass(frozen=True)
class Forming:
    """How files become records.

    Attributes
    ----------
    folder : path
        Base of record ids.
    config : MeasuredConfig
    """

    folder: Path
    config: MeasuredConfig

    def records(self, path: Path) -> list[MeasuredRecord | RejectedRecord]:
        """The records of a file, or a rejection with the reason.

        Raises
        ------
        DataError
            The file is not as described.
        """
        with np.errstate(all="ignore"):
            return list(self._records(path))

    def held(self, table: Table, record_id: str) -> MeasuredRecord | RejectedRecord:
        """The record of a table in memory.

        Raises
        ------
        DataError
            It is not as described.
        """
        with np.errstate(all="ignore"):
            try:
                recording = recording_of(table, self.config)
            except RejectionError as rejection:
                return RejectedRecord(record_id, table.place, "", rejection.remark)
            return self._record(record_id, table.place, {}, recording)

    def _records(self, path: Path) -> Iterator[MeasuredRecord | RejectedRecord]:
        place, config = place_of(path, self.folder), self.config
        names = names_of_path(place, self._pattern)
        try:
            if names is None:
                raise RejectionError("path", f"the path does not match {config.path!r}")
            recording = trimmed(read_recording(path, str(path), config), config.trim)
            cycles = [recording] if config.cycles is None else list(cycles_of(recording, config.cycles))
        except RejectionError as rejection:
            yield RejectedRecord(place, place, "", rejection.remark)
            return
        for number, cycle in enumerate(cycles, 1):
            record_id = place if config.cycles is None else f"{place}#{number}"
            if isinstance(cycle, RejectionError):
                yield RejectedRecord(record_id, place, "", cycle.remark)
            else:
                yield self._record(record_id, place, names | dict(cycle.values), cycle)

    def _record(
        self, record_id: str, place: str, names: dict[str, str], cycle: Recording
    ) -> MeasuredRecord | RejectedRecord:
        config, stroke = self.config, self._stroke(cycle)
        names |= {"direction": stroke.direction if stroke else "0"}
        group, label = (filled(template, names) for template in (config.group, config.label))
        try:
            recording = self._part(cycle, stroke)
        except RejectionError as rejection:
            return RejectedRecord(record_id, place, group, rejection.remark, label)
        return MeasuredRecord(record_id, place, group, label, recording, stroke.distance if stroke else 0.0)

    def _part(self, cycle: Recording, stroke: Stroke | None) -> Recording:
        """The requested part of a cycle, with its findings."""
        config = self.config
        recording = cycle if config.segment is None else segment_of(cycle, stroke, config.segment)
        found = [*short_stroke(cycle, stroke, config.limits.shortest_stroke)]
        found += defects(recording, config.limits, self._ranges)
        recording = replace(recording, remarks=(*recording.remarks, *found))
        if config.normalize == "none":
            return recording
        return normalized(recording, config.normalize, reference_pressure(cycle, config.normalize))

    def _stroke(self, recording: Recording) -> Stroke | None:
        position = recording.channels.get(Channel.PISTON_POSITION)
        return None if position is None else find_stroke(position)

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        return path_pattern(self.config.path)

    @cached_property
    def _ranges(self) -> Ranges:
        pairs = ((name, column.plausible_range(name.unit)) for name, column in self.config.channels.items())
        return {channel: limits for channel, limits in pairs if limits is not None}


MOST_SAMPLES = 2**22
"""Most samples, over all channels, of a batch with more than one record: 32 MiB."""


def batched(
    records: Iterable[MeasuredRecord | RejectedRecord],
    drive_period: float | None,
    labels: bool,
    most_samples: int = MOST_SAMPLES,
) -> Iterator[RecordBatch]:
    """Batches of consecutive records that fit together; rejected records come with the next batch.

    Parameters
    ----------
    records : iterable of MeasuredRecord or RejectedRecord
    drive_period : float or None
        [s].
    labels : bool
        Whether batches contain the labels of their records.
    most_samples : int
        Most samples, over all channels, of a batch with more than one record.
    """
    waiting: list[MeasuredRecord] = []
    rejected: list[RejectedRecord] = []
    for record in records:
        if isinstance(record, RejectedRecord):
            rejected.append(record if labels else replace(record, label=""))
            continue
        if waiting and (_shape(record) != _shape(waiting[0]) or _is_full(waiting, most_samples)):
            yield _batch(waiting, rejected, drive_period, labels)
            waiting, rejected = [], []
        waiting.append(record)
    if waiting or rejected:
        yield _batch(waiting, rejected, drive_period, labels)


def _shape(record: MeasuredRecord) -> Hashable:
    return record.recording.n_time, record.recording.sampling, record.recording.relative


def _is_full(records: list[MeasuredRecord], most_samples: int) -> bool:
    first = records[0].recording
    return (len(records) + 1) * first.n_time * len(first.channels) > most_samples


def _batch(
    records: list[MeasuredRecord],
    rejected: list[RejectedRecord],
    drive_period: float | None,
    labels: bool,
) -> RecordBatch:
    if not records:
        return RecordBatch({}, 1.0, (), rejected=tuple(rejected), labels=() if labels else None)
    first = records[0].recording
    return RecordBatch(
        channels={
            channel: np.stack([record.recording.channels[channel] for record in records])
            if len(records) > 1
            else first.channels[channel][np.newaxis]
            for channel in first.channels
        },
        sampling_frequency=first.sampling.frequency,
        start_time=first.sampling.start,
        record_ids=tuple(record.record_id for record in records),
        sources=tuple(record.source for record in records),
        groups=tuple(record.group for record in records),
        drive_period=drive_period,
        relative=first.relative,
        normalized=first.normalized,
        remarks=tuple(record.recording.remarks for record in records),
        rejected=tuple(rejected),
        units={
            channel: frozenset(record.recording.units[channel] for record in records)
            for channel in first.units
        },
        labels=tuple(record.label for record in records) if labels else None,
    )


_DIGITS = re.compile(r"(\d+)")


def matching_files(folder: Path, pattern: str) -> list[Path]:
    """Files that match a pattern, in natural order: run 2 before run 10.

    Leading parts of the pattern that exist literally are taken literally, including brackets and stars.

    Parameters
    ----------
    folder : path
        Base of relative patterns.
    pattern : str
    """
    parts = PurePath(pattern).parts
    literal = 0
    while literal < len(parts) and os.path.lexists(folder.joinpath(*parts[: literal + 1])):
        literal += 1
    start = folder.joinpath(*parts[:literal])
    if literal == len(parts):
        return [start] if start.is_file() else []
    found = glob.glob(os.path.join(*parts[literal:]), root_dir=start, recursive=True)
    return in_natural_order(start / name for name in found if (start / name).is_file())


def in_natural_order(paths: Iterable[Path]) -> list[Path]:
    """Paths in natural order: numbers in them are sorted by value."""
    return sorted(paths, key=lambda path: _natural(path.as_posix()))


def place_of(path: Path, folder: Path) -> str:
    """The path relative to a folder, with forward slashes: the name of a record."""
    return Path(os.path.relpath(path, folder)).as_posix()


def _natural(text: str) -> tuple[list[tuple[str, int]], str]:
    pieces = _DIGITS.split(text)
    numbers = [int(piece) for piece in pieces[1::2]] + [0]
    return list(zip(pieces[::2], numbers, strict=True)), text
