"""Measured files as a source of records."""

from __future__ import annotations

import glob
import math
import os
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from hydrofdi.errors import ConfigError, DataError, Issue
from hydrofdi.records import Array, Channel, RecordBatch, RejectedRecord, description
from hydrofdi.records.columns import FileColumns, RejectionError
from hydrofdi.records.data_sheet import usual_sheet_lines
from hydrofdi.records.defects import defects, differences
from hydrofdi.records.files import open_table
from hydrofdi.records.proposals import completed, proposed_description
from hydrofdi.records.recording import (
    Recording,
    cycles_of,
    find_stroke,
    normalized,
    recording_of,
    reference_pressure,
    segment_of,
    short_stroke,
    trimmed,
)
from hydrofdi.records.times import instant
from hydrofdi.settings.files import Source, read_yaml, validated, write_new

MOST_SAMPLES = 2**22
"""Most samples, over all channels, of a batch with more than one record: 32 MiB."""


def batched(
    records: Iterable[Recording | RejectedRecord],
    drive_period: float | None,
    labels: bool,
    most_samples: int = MOST_SAMPLES,
) -> Iterator[RecordBatch]:
    """Batches of consecutive records that fit together; rejected records come with the next batch.

    A batch of more than one record has at most `most_samples` over all channels.
    """
    waiting: list[Recording] = []
    rejected: list[RejectedRecord] = []
    for record in records:
        if isinstance(record, RejectedRecord):
            rejected.append(record if labels else replace(record, label=""))
            continue
        n_sample = (len(waiting) + 1) * record.n_time * len(record.channels)
        if waiting and (_shape(record) != _shape(waiting[0]) or n_sample > most_samples):
            yield _batch(waiting, rejected, drive_period, labels)
            waiting, rejected = [], []
        waiting.append(record)
    if waiting or rejected:
        yield _batch(waiting, rejected, drive_period, labels)


def _shape(record: Recording) -> Hashable:
    return record.n_time, record.sampling_frequency, record.start_time, record.relative


def _batch(
    records: list[Recording], rejected: list[RejectedRecord], drive_period: float | None, labels: bool
) -> RecordBatch:
    if not records:
        return RecordBatch({}, 1.0, (), rejected=tuple(rejected), labels=() if labels else None)
    first = records[0]
    return RecordBatch(
        channels={
            channel: np.stack([record.channels[channel] for record in records])
            if len(records) > 1
            else first.channels[channel][np.newaxis]
            for channel in first.channels
        },
        sampling_frequency=first.sampling_frequency,
        start_time=first.start_time,
        record_ids=tuple(record.record_id for record in records),
        sources=tuple(record.source for record in records),
        groups=tuple(record.group for record in records),
        drive_period=drive_period,
        relative=first.relative,
        normalized=first.normalized,
        remarks=tuple(record.remarks for record in records),
        rejected=tuple(rejected),
        units={channel: frozenset(record.units[channel] for record in records) for channel in first.units},
        labels=tuple(record.label for record in records) if labels else None,
        dates=tuple(record.date for record in records),
    )


@dataclass(frozen=True)
class MeasuredSource:
    """Records of measured files, read one file at a time; ids are relative to `folder`.

    `remarks` are on every record; a batch of more than one record has at most `most_samples` over all
    channels.
    """

    name: str
    config: description.MeasuredConfig
    files: Sequence[Path] = ()
    folder: Path = Path()
    remarks: tuple[Issue, ...] = ()
    most_samples: int = MOST_SAMPLES

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records in the natural order of their paths."""
        cycles = self.config.cycles
        period = self.config.drive_period or (None if cycles is None else cycles.period)
        yield from batched(self._remarked(), period, labels, self.most_samples)

    @property
    def data_sheet(self) -> Mapping[str, Any]:
        """What the description states of the machine."""
        return self.config.actuator.given

    @property
    def is_labelled(self) -> bool:
        """Whether the description says how records are labelled."""
        return bool(self.config.label)

    def _remarked(self) -> Iterator[Recording | RejectedRecord]:
        """The records, with remarks on differences from the first."""
        first: Recording | None = None
        for record in self._records():
            if isinstance(record, RejectedRecord):
                yield record
                continue
            first = first or replace(record, channels={})
            yield record.remarked((*self.remarks, *differences(record, first)))

    def _records(self) -> Iterator[Recording | RejectedRecord]:
        """The records of all files, or a rejection with the reason."""
        for path in self.files:
            with np.errstate(all="ignore"):
                records = [*self._of_file(path)]
            yield from records

    def _of_file(self, path: Path) -> Iterator[Recording | RejectedRecord]:
        source, config = Path(os.path.relpath(path, self.folder)).as_posix(), self.config
        names = description.names_of_path(source, self._pattern)
        try:
            if names is None:
                raise RejectionError("path", f"the path does not match {config.path!r}")
            with open_table(path, str(path), config.format) as table:
                recording = recording_of(table, config)
            if config.date:
                recording = replace(recording, date=_date(description.filled(config.date, names)))
            recording = trimmed(recording, config.trim)
            cycles = [recording] if config.cycles is None else list(cycles_of(recording, config.cycles))
        except RejectionError as rejection:
            yield RejectedRecord(source, source, "", rejection.remark)
            return
        for number, cycle in enumerate(cycles, 1):
            record_id = source if config.cycles is None else f"{source}#{number}"
            if isinstance(cycle, RejectionError):
                yield RejectedRecord(record_id, source, "", cycle.remark)
            else:
                yield self._formed(replace(cycle, record_id=record_id, source=source), names)

    def _formed(self, cycle: Recording, names: Mapping[str, str]) -> Recording | RejectedRecord:
        """The requested part of a cycle, with its group, label and findings."""
        config, position = self.config, cycle.channels.get(Channel.PISTON_POSITION)
        stroke = None if position is None else find_stroke(position)
        known = {**names, "direction": stroke.direction if stroke else "0"}
        group, label = (description.filled(template, known) for template in (config.group, config.label))
        try:
            record = cycle if config.segment is None else segment_of(cycle, stroke, config.segment)
            remarks = [*short_stroke(cycle, stroke, config.limits.shortest_stroke)]
            own = config.actuator.ranges.items()
            ranges = {name: limits for name, limits in own if name not in record.relative} | self._ranges
            record = record.remarked((*remarks, *defects(record, config.limits, ranges)))
            if config.normalize != "none":
                record = normalized(record, config.normalize, reference_pressure(cycle, config.normalize))
        except RejectionError as rejection:
            return RejectedRecord(cycle.record_id, cycle.source, group, rejection.remark, label)
        return replace(record, group=group, label=label)

    @cached_property
    def _pattern(self) -> re.Pattern[str]:
        return description.path_pattern(self.config.path)

    @cached_property
    def _ranges(self) -> dict[Channel, tuple[float, float]]:
        pairs = ((name, column.plausible_range(name.unit)) for name, column in self.config.channels.items())
        return {channel: limits for channel, limits in pairs if limits is not None}


def _date(text: str) -> float:
    """A date since 1970 [s]."""
    try:
        return instant(text).nanoseconds / 1e9
    except ValueError as error:
        raise RejectionError("date", str(error)) from None


def measured_source(path: Path | str, *, most_samples: int = MOST_SAMPLES) -> MeasuredSource:
    """The records of the files that a YAML file describes; its patterns are relative to its folder."""
    file = Path(path)
    source = read_yaml(file, "a description of measured files")
    source.data = {
        key: value for key, value in (source.data or {}).items() if key not in description.OF_STREAMS
    }
    config = validated(description.MeasuredConfig, source)
    if config.channels:
        _require_consistent(config, source)
    files = in_natural_order(_files(config, source, file.parent))
    unused: tuple[Issue, ...] = ()
    if not config.channels:
        config, unused = completed(config, files)
        if config.channels:
            _require_consistent(config, source)
    return MeasuredSource(str(path), config, files, file.parent, unused, most_samples)


def _files(config: description.MeasuredConfig, source: Source, folder: Path) -> set[Path]:
    files: set[Path] = set()
    for number, pattern in enumerate(config.files):
        matching = matching_files(folder, pattern)
        if not matching:
            message = f"no file matches {pattern!r} in {folder.resolve().name}"
            raise ConfigError([source.mistake(("files", number), message)])
        files.update(matching)
    return files


def _require_consistent(config: description.MeasuredConfig, source: Source) -> None:
    mistakes = list(description.contradictions(config, source))
    if mistakes:
        raise ConfigError(mistakes)


@dataclass(frozen=True)
class MemoryTable(FileColumns):
    """Columns of one or more records in memory, each of shape (n_time,) or (n_record, n_time).

    A unit is empty if it is not stated, and None if there is no place to state it. `time` is the position of
    the column of time; dates count from the first of them: position → that date since 1970 [s]. Names, groups
    and labels of the records are empty if there are none.
    """

    place: str
    titles: Sequence[str]
    units: Sequence[str | None]
    columns: Sequence[Array]
    dates: Mapping[int, float] = field(default_factory=dict)
    time: int | None = None
    record_ids: Sequence[str] = ()
    groups: Sequence[str] = ()
    labels: Sequence[str] = ()

    def unit(self, position: int) -> str:
        """Unit of a column; empty if unknown."""
        return self.units[position] or ""

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return position in self.dates

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_time,)."""
        return self.columns[position]

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, and the first date."""
        return self.columns[position], self.dates.get(position, math.nan)

    def part(self, positions: Sequence[int], time: int | None) -> MemoryTable:
        """Some of the columns, of which one may be the time."""
        return replace(
            self,
            titles=[self.titles[n] for n in positions],
            units=[self.units[n] for n in positions],
            columns=[self.columns[n] for n in positions],
            dates={index: self.dates[n] for index, n in enumerate(positions) if n in self.dates},
            time=None if time is None else positions.index(time),
        )

    def row(self, row: int) -> MemoryTable:
        """One of the records."""
        return replace(self, columns=[column if column.ndim == 1 else column[row] for column in self.columns])


@dataclass(frozen=True)
class HeldSource(MeasuredSource):
    """Records in memory; `table` has a name, a group and a label for each."""

    table: MemoryTable = MemoryTable("", (), (), ())

    @property
    def is_labelled(self) -> bool:
        """Whether any record has a label."""
        return any(self.table.labels)

    def _records(self) -> Iterator[Recording | RejectedRecord]:
        table = self.table
        named = zip(table.record_ids, table.groups, table.labels, strict=True)
        for row, (record_id, group, label) in enumerate(named):
            with np.errstate(all="ignore"):
                record = self._of_row(row, record_id)
            yield replace(record, group=group, label=label)

    def _of_row(self, row: int, record_id: str) -> Recording | RejectedRecord:
        place = self.table.place
        try:
            record = recording_of(self.table.row(row), self.config)
        except RejectionError as rejection:
            return RejectedRecord(record_id, place, "", rejection.remark)
        return self._formed(replace(record, record_id=record_id, source=place), {})


def held_source(table: MemoryTable, described: Mapping[str, Any]) -> HeldSource:
    """Records in memory, with ``channels`` and sampling as in a description."""
    source = Source({"files": table.place, **described})
    config = validated(description.MeasuredConfig, source)
    _require_consistent(config, source)
    return HeldSource(table.place, config, table=table)


_SUFFIXES_IN_FOLDERS = tuple(
    ".csv .tsv .lvm .parquet .pq .mat .npz .mf4 .tdms .csv.gz .tsv.gz".split()  # noqa: SIM905
)
"""Suffixes of records in a folder; a text such as readme.txt may be anything."""


def plain_source(path: Path | str, sampling_frequency: float | None = None) -> MeasuredSource:
    """The records of one file whose headers name channels and units, or of a folder of them.

    All files of a folder have the columns of the first readable one; subfolders and hidden files are not
    read.
    """
    folder = Path(path)
    files = _files_at(folder)
    sampling = {} if sampling_frequency is None else {"sampling_frequency": sampling_frequency}
    named = validated(description.MeasuredConfig, Source({"files": [file.name for file in files]} | sampling))
    config, unused = completed(named, files, is_plain=True)
    return MeasuredSource(str(path), config, files, folder if folder.is_dir() else folder.parent, unused)


def write_description(path: Path, file: Path, sampling_frequency: float | None = None) -> str:
    """Write what the headers of a measured file, or of a folder of them, state as a description; its text."""
    files = _files_at(path)
    pattern = os.path.relpath(path / f"*{files[0].suffix}" if path.is_dir() else path, file.parent)
    text = proposed_description(files[0], pattern, sampling_frequency)
    text = "\n".join([text, *usual_sheet_lines()]) + "\n"
    write_new(file, text)
    return text


def _files_at(path: Path) -> list[Path]:
    files = plain_files(path) if path.is_dir() else [path]
    if not files:
        raise DataError(
            f"{path}: contains no results of hydrofdi and no measured files such as .csv; describe other"
            " measured files in a YAML (docs/measured.md)"
        )
    return files


def plain_files(folder: Path) -> list[Path]:
    """The files of a folder that are read as records, in natural order."""
    return in_natural_order(
        [
            file
            for file in folder.iterdir()
            if file.is_file() and file.name[0] != "." and file.name.lower().endswith(_SUFFIXES_IN_FOLDERS)
        ]
    )


_DIGITS = re.compile(r"(\d+)")


def matching_files(folder: Path, pattern: str) -> list[Path]:
    """Files that match a pattern relative to a folder, in natural order: run 2 before run 10.

    Leading parts of the pattern that exist literally are taken literally, including brackets and stars.
    """
    parts = PurePath(pattern).parts
    literal = 0
    while literal < len(parts) and os.path.lexists(folder.joinpath(*parts[: literal + 1])):
        literal += 1
    start = folder.joinpath(*parts[:literal])
    if literal == len(parts):
        return [start] if start.is_file() else []
    names = glob.glob(os.path.join(*parts[literal:]), root_dir=start, recursive=True)
    return in_natural_order(start / name for name in names if (start / name).is_file())


def in_natural_order(paths: Iterable[Path]) -> list[Path]:
    """Paths in natural order: numbers in them are sorted by value."""
    return sorted(paths, key=lambda path: (_natural(path.as_posix()), path.as_posix()))


def _natural(text: str) -> list[int | str]:
    """Texts and, at odd positions, the numbers between them."""
    return [int(piece) if n % 2 else piece for n, piece in enumerate(_DIGITS.split(text))]
