"""Measured files as a source of records."""

from __future__ import annotations

import glob
import math
import os
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from itertools import chain
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
    Record,
    cycles_of,
    find_stroke,
    normalized,
    recording_of,
    segment_of,
    short_stroke,
    trimmed,
)
from hydrofdi.records.times import instant
from hydrofdi.settings.files import Source, read_yaml, validated, write_new

_MOST_SAMPLES = 2**22
"""Most samples, over all channels, of a batch with more than one record: 32 MiB."""


def _shape(record: Record) -> Hashable:
    return record.n_time, record.sampling_frequency, record.start_time, record.relative


def _batch(records: list[Record], rejected: list[RejectedRecord], labels: bool) -> RecordBatch:
    """Records that fit together."""
    if not records:
        return RecordBatch({}, 1.0, (), rejected=tuple(rejected), labels=() if labels else None)
    first, joined = records[0], dict[str, Any](labels=None, rejected=tuple(rejected))
    for name in ("record_ids", "sources", "groups", "remarks", "dates", *["labels"] * labels):
        joined[name] = tuple(chain.from_iterable(getattr(record, name) for record in records))
    if len(records) > 1:
        names = first.channels
        joined["channels"] = {name: np.concatenate([each[name] for each in records]) for name in names}
        joined["units"] = {name: frozenset().union(*(each.units[name] for each in records)) for name in names}
    return replace(first, **joined)


@dataclass(frozen=True)
class MeasuredSource:
    """Records of measured files, read one file at a time; ids are relative to `folder`.

    `remarks` are on every record.
    """

    name: str
    config: description.MeasuredConfig
    files: Sequence[Path] = ()
    folder: Path = Path()
    remarks: tuple[Issue, ...] = ()

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records in the natural order of their paths; rejected ones come with the next batch."""
        waiting, rejected = list[Record](), list[RejectedRecord]()
        for record in self._remarked():
            if isinstance(record, RejectedRecord):
                rejected.append(record if labels else replace(record, label=""))
                continue
            n_sample = (len(waiting) + 1) * record.n_time * len(record.channels)
            if waiting and (_shape(record) != _shape(waiting[0]) or n_sample > _MOST_SAMPLES):
                yield _batch(waiting, rejected, labels)
                waiting, rejected = [], []
            waiting.append(record)
        if waiting or rejected:
            yield _batch(waiting, rejected, labels)

    @property
    def data_sheet(self) -> Mapping[str, Any]:
        """What the description states of the machine."""
        return self.config.actuator.given

    @property
    def is_labelled(self) -> bool:
        """Whether the description says how records are labelled."""
        return bool(self.config.label)

    def _remarked(self) -> Iterator[Record | RejectedRecord]:
        """The records, with remarks on differences from the first."""
        first: Record | None = None
        for record in self._records():
            if isinstance(record, RejectedRecord):
                yield record
                continue
            first = first or replace(record, channels={})
            yield record.remarked((*self.remarks, *differences(record, first)))

    def _records(self) -> Iterator[Record | RejectedRecord]:
        """The records of all files, or a rejection with the reason."""
        for path in self.files:
            source = Path(os.path.relpath(path, self.folder)).as_posix()
            yield from self._of_table(source, open_table(path, str(path), self.config.format))

    @np.errstate(all="ignore")
    def _of_table(
        self, source: str, opened: AbstractContextManager[FileColumns]
    ) -> list[Record | RejectedRecord]:
        config = self.config
        names = description.names_of_path(source, description.path_pattern(config.path))
        try:
            if names is None:
                raise RejectionError("path", f"the path does not match {config.path!r}")
            with opened as table:
                recording = recording_of(table, config)
            if config.date:
                recording = replace(recording, dates=(_date(description.filled(config.date, names)),))
            recording = trimmed(recording, config.trim)
            cycles = [recording] if config.cycles is None else list(cycles_of(recording, config.cycles))
        except RejectionError as rejection:
            return [RejectedRecord(source, source, "", rejection.remark)]
        records = list[Record | RejectedRecord]()
        for number, cycle in enumerate(cycles, 1):
            record_id = source if config.cycles is None else f"{source}#{number}"
            if isinstance(cycle, RejectionError):
                records.append(RejectedRecord(record_id, source, "", cycle.remark))
            else:
                records.append(
                    self._formed(replace(cycle, record_ids=(record_id,), sources=(source,)), names)
                )
        return records

    def _formed(self, cycle: Record, names: Mapping[str, str]) -> Record | RejectedRecord:
        """The requested part of a cycle, with its group, label and findings."""
        config, position = self.config, cycle.channels.get(Channel.PISTON_POSITION)
        stroke = None if position is None else find_stroke(position[0])
        known = {**names, "direction": stroke.direction if stroke else "0"}
        group, label = (description.filled(template, known) for template in (config.group, config.label))
        try:
            record = cycle if config.segment is None else segment_of(cycle, stroke, config.segment)
            remarks = [*short_stroke(cycle, stroke, config.limits.shortest_stroke)]
            own = ((name, column.plausible_range(name.unit)) for name, column in config.channels.items())
            sheet = config.actuator.ranges.items()
            ranges = {name: limits for name, limits in sheet if name not in record.relative}
            ranges |= {name: limits for name, limits in own if limits is not None}
            record = record.remarked((*remarks, *defects(record, config.limits, ranges)))
            if config.normalize != "none":
                record = normalized(record, cycle, config.normalize)
        except RejectionError as rejection:
            return RejectedRecord(cycle.record_ids[0], cycle.sources[0], group, rejection.remark, label)
        return replace(record, groups=(group,), labels=(label,))


def _date(text: str) -> float:
    """A date since 1970 [s]."""
    try:
        return instant(text).nanoseconds / 1e9
    except ValueError as error:
        raise RejectionError("date", str(error)) from None


def measured_source(path: Path | str) -> MeasuredSource:
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
    return MeasuredSource(str(path), config, files, file.parent, unused)


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
    the column of time; dates count from the first of them: position → that date since 1970 [s]. The record
    `at` is read. Names, groups and labels of the records are empty if there are none.
    """

    place: str
    titles: Sequence[str]
    units: Sequence[str | None]
    columns: Sequence[Array]
    dates: Mapping[int, float] = field(default_factory=dict)
    time: int | None = None
    at: int = 0
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
        """Values of a column of the record `at`, shape (n_time,)."""
        column = self.columns[position]
        return column if column.ndim == 1 else column[self.at]

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, and the first date."""
        return self.numbers(position), self.dates.get(position, math.nan)


@dataclass(frozen=True)
class HeldSource(MeasuredSource):
    """Records in memory; `table` has a name, a group and a label for each."""

    table: MemoryTable = MemoryTable("", (), (), ())

    @property
    def is_labelled(self) -> bool:
        """Whether any record has a label."""
        return any(self.table.labels)

    def _records(self) -> Iterator[Record | RejectedRecord]:
        table = self.table
        named = zip(table.record_ids, table.groups, table.labels, strict=True)
        for row, (record_id, group, label) in enumerate(named):
            (record,) = self._of_table(table.place, nullcontext(replace(table, at=row)))
            if isinstance(record, RejectedRecord):
                yield replace(record, record_id=record_id, group=group, label=label)
            else:
                yield replace(record, record_ids=(record_id,), groups=(group,), labels=(label,))


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
