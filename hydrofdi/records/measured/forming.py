"""A measured file → its records, each with a name, a group and findings."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.records.batch import RejectedRecord
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.description.ranges import plausible_range
from hydrofdi.records.measured.files import place_of
from hydrofdi.records.measured.findings.defects import Ranges, defects
from hydrofdi.records.measured.formats.table import Table
from hydrofdi.records.measured.naming import filled, names_of_path, path_pattern
from hydrofdi.records.measured.parts.cutting import cycles_of, segment_of, trimmed
from hydrofdi.records.measured.parts.normalizing import normalized, reference_pressure
from hydrofdi.records.measured.parts.stroke import Stroke, find_stroke, short_stroke
from hydrofdi.records.measured.recording import Recording, read_recording, recording_of
from hydrofdi.records.measured.rejection import RejectionError


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
        pairs = ((name, plausible_range(name, column)) for name, column in self.config.channels.items())
        return {channel: limits for channel, limits in pairs if limits is not None}
