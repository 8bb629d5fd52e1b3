"""Measured files as a source of records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.records.batch import RecordBatch, RejectedRecord
from hydrofdi.records.measured.batching import MOST_SAMPLES, batched
from hydrofdi.records.measured.description.checks import contradictions
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.files import in_natural_order, matching_files
from hydrofdi.records.measured.findings.consistency import differences
from hydrofdi.records.measured.findings.outliers import outliers
from hydrofdi.records.measured.forming import Forming, MeasuredRecord
from hydrofdi.records.measured.headers import completed
from hydrofdi.records.measured.recording import Recording
from hydrofdi.settings.validation import read_yaml, validated
from hydrofdi.settings.yaml_source import Source


@dataclass(frozen=True)
class MeasuredSource:
    """Records of measured files, read one file at a time.

    Attributes
    ----------
    name : str
        The description, or the file.
    folder : path
        Base of record ids.
    config : MeasuredConfig
    files : sequence of path
    remarks : tuple of Issue
        Remarks on every record.
    most_samples : int
        Most samples, over all channels, of a batch with more than one record.
    """

    name: str
    folder: Path
    config: MeasuredConfig
    files: Sequence[Path]
    remarks: tuple[Issue, ...] = ()
    most_samples: int = MOST_SAMPLES

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records in the natural order of their paths.

        Raises
        ------
        DataError
            A file is not as described.
        """
        cycles = self.config.cycles
        period = self.config.drive_period or (None if cycles is None else cycles.period)
        yield from batched(self._judged(), period, labels, self.most_samples)

    @property
    def is_labelled(self) -> bool:
        """Whether the description says how records are labelled."""
        return bool(self.config.label)

    def _judged(self) -> Iterator[MeasuredRecord | RejectedRecord]:
        """The records, with remarks on differences from the first, and on outliers if requested."""
        limit = self.config.limits.outliers
        found = {} if limit is None else outliers(self._records(), limit)
        first: Recording | None = None
        for record in self._records():
            remarks = found.get(record.record_id, ())
            if isinstance(record, RejectedRecord):
                yield record
                continue
            first = first or replace(record.recording, channels={})
            yield record.remarked((*self.remarks, *remarks, *differences(record.recording, first)))

    def _records(self) -> Iterator[MeasuredRecord | RejectedRecord]:
        forming = Forming(self.folder, self.config)
        for path in self.files:
            yield from forming.records(path)


def measured_source(path: Path | str, *, most_samples: int = MOST_SAMPLES) -> MeasuredSource:
    """The records of the files that a YAML file describes.

    Parameters
    ----------
    path : path
        The description; its patterns are relative to its folder.
    most_samples : int
        Most samples, over all channels, of a batch with more than one record.

    Raises
    ------
    ConfigError
        The description is wrong (all mistakes are listed), or no file matches.
    """
    file = Path(path)
    source = read_yaml(file, "a description of measured files")
    config = validated(MeasuredConfig, source)
    if config.channels:
        _require_consistent(config, source)
    files = in_natural_order(_files(config, source, file.parent))
    unused: tuple[Issue, ...] = ()
    if not config.channels:
        config, unused = completed(config, files)
        _require_consistent(config, source)
    return MeasuredSource(str(path), file.parent, config, files, unused, most_samples)


def _files(config: MeasuredConfig, source: Source, folder: Path) -> set[Path]:
    files: set[Path] = set()
    for number, pattern in enumerate(config.files):
        found = matching_files(folder, pattern)
        if not found:
            message = f"no file matches {pattern!r} in {folder.resolve().name}"
            raise ConfigError([source.mistake(("files", number), message)])
        files.update(found)
    return files


def described(source: Source) -> MeasuredConfig:
    """The description in a source.

    Raises
    ------
    ConfigError
        The description is wrong; all mistakes are listed.
    """
    config = validated(MeasuredConfig, source)
    _require_consistent(config, source)
    return config


def _require_consistent(config: MeasuredConfig, source: Source) -> None:
    mistakes = list(contradictions(config, source))
    if mistakes:
        raise ConfigError(mistakes)
