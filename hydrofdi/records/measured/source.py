"""Measured files as a source of records."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import ConfigError, DataError, Issue
from hydrofdi.records.batch import Array, Channel, RecordBatch, RejectedRecord
from hydrofdi.records.measured.defects import differences
from hydrofdi.records.measured.description.checks import contradictions
from hydrofdi.records.measured.description.sections import OF_STREAMS, MeasuredConfig
from hydrofdi.records.measured.formats.table import Table
from hydrofdi.records.measured.forming import (
    MOST_SAMPLES,
    Forming,
    MeasuredRecord,
    batched,
    in_natural_order,
    matching_files,
)
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
    source.data = {key: value for key, value in (source.data or {}).items() if key not in OF_STREAMS}
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


@dataclass(frozen=True)
class HeldTable(Table):
    """Columns of one record.

    Attributes
    ----------
    place : str
        Name of the record in messages.
    titles, units : sequence of str
        Name and unit of each column; the unit is empty if unknown.
    columns : sequence of ndarray, shape (n_time,)
    record_id, group, label : str
        Group and label are empty if unknown.
    """

    place: str
    titles: Sequence[str]
    units: Sequence[str]
    columns: Sequence[Array]
    record_id: str = "0"
    group: str = ""
    label: str = ""

    def unit(self, position: int) -> str:
        """Unit of a column; empty if unknown."""
        return self.units[position]

    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_time,)."""
        return self.columns[position]

    def text(self, position: int) -> str:
        """Raise `DataError`: these columns contain only numbers."""
        raise DataError(f"{self.place}: column {self.titles[position]!r} is not text")


@dataclass(frozen=True)
class HeldSource:
    """Records in memory.

    Attributes
    ----------
    name : str
        Name in messages.
    tables : sequence of HeldTable
        One for each record.
    config : MeasuredConfig
    is_simulated : bool
        Whether an experiment file states the plant.
    """

    name: str
    tables: Sequence[HeldTable]
    config: MeasuredConfig
    is_simulated: bool = False

    def batches(self, *, labels: bool = False) -> Iterator[RecordBatch]:
        """All records in their order.

        Raises
        ------
        DataError
            A unit is unknown, or of another dimension.
        """
        yield from batched(map(self._record, self.tables), None, labels)

    @property
    def is_labelled(self) -> bool:
        """Whether any record has a label."""
        return any(table.label for table in self.tables)

    def _record(self, table: HeldTable) -> MeasuredRecord | RejectedRecord:
        record = Forming(Path(), self.config).held(table, table.record_id)
        return replace(record, group=table.group, label=table.label)


def held_source(
    tables: Sequence[HeldTable], channels: Mapping[Channel, Mapping[str, str]], sampling: Mapping[str, Any]
) -> HeldSource:
    """Records of tables with the same columns.

    Parameters
    ----------
    tables : sequence of HeldTable
    channels : mapping
        Channel → ``column``, and ``unit`` if the table does not state it.
    sampling : mapping
        ``time`` or ``sampling_frequency``, as in a description of measured files.

    Raises
    ------
    ConfigError
        The columns do not fit; all mistakes are listed.
    """
    columns = {channel.value: dict(column) for channel, column in channels.items()}
    name = tables[0].place if tables else "the records"
    return HeldSource(name, tables, described(Source({"files": name, "channels": columns, **sampling})))


_SUFFIXES_IN_FOLDERS = (".csv", ".tsv", ".parquet", ".pq", ".mat", ".npz", ".csv.gz", ".tsv.gz")
"""Suffixes of records in a folder; a text such as readme.txt may be anything."""


def plain_source(path: Path | str, sampling_frequency: float | None = None) -> MeasuredSource:
    """The records of one file whose headers name channels and units, or of a folder of them.

    Parameters
    ----------
    path : path
        All files of a folder have the columns of the first; subfolders and hidden files are not read.
    sampling_frequency : float, optional
        [Hz]; needed if there is no column ``time [s]``.

    Raises
    ------
    DataError
        The folder has no such files, or the headers are not sufficient; the message shows the description to
        write.
    """
    place = Path(path)
    files = plain_files(place) if place.is_dir() else [place]
    if not files:
        raise DataError(
            f"{path}: contains no results of hydrofdi and no measured files such as .csv; describe other"
            " measured files in a YAML (docs/measured.md)"
        )
    sampling = {} if sampling_frequency is None else {"sampling_frequency": sampling_frequency}
    named = validated(MeasuredConfig, Source({"files": [file.name for file in files]} | sampling))
    config, unused = completed(named, files, is_plain=True)
    return MeasuredSource(str(path), place if place.is_dir() else place.parent, config, files, unused)


def plain_files(folder: Path) -> list[Path]:
    """The files of a folder that are read as records, in natural order."""
    return in_natural_order(
        [
            file
            for file in folder.iterdir()
            if file.is_file() and file.name[0] != "." and file.name.lower().endswith(_SUFFIXES_IN_FOLDERS)
        ]
    )


_FEWEST = 8
"""Fewest records of a group that is checked."""
_TO_DEVIATION = 1.4826
"""Standard deviation of normal numbers over their median absolute deviation."""

Key = tuple[str, Channel]
"""Group and channel."""


def outliers(
    records: Iterable[MeasuredRecord | RejectedRecord], limit: float
) -> dict[str, tuple[Issue, ...]]:
    """Record id → remarks, for records that are further from the median of their group than others.

    The check compares the stroke, and the logarithm of the RMS of each pressure's changes from sample to
    sample.

    Parameters
    ----------
    records : iterable of MeasuredRecord or RejectedRecord
        Only a few numbers of each are kept.
    limit : float
        Largest usual distance from the median, in robust standard deviations.
    """
    names: dict[Key, list[str]] = defaultdict(list)
    numbers: dict[Key, list[float]] = defaultdict(list)
    for record in records:
        if isinstance(record, MeasuredRecord):
            for channel, number in _looked_at(record).items():
                names[record.group, channel].append(record.record_id)
                numbers[record.group, channel].append(number)
    found: dict[str, tuple[Issue, ...]] = defaultdict(tuple)
    for key, values in numbers.items():
        distances = _distances(np.array(values))
        for row in np.flatnonzero(distances > limit).tolist():
            found[names[key][row]] += (_remark(key[1], float(distances[row])),)
    return found


def _looked_at(record: MeasuredRecord) -> dict[Channel, float]:
    channels = record.recording.channels
    numbers = {Channel.PISTON_POSITION: record.stroke} if Channel.PISTON_POSITION in channels else {}
    for channel, samples in channels.items():
        if channel.is_pressure:
            change = float(np.sqrt(np.mean(np.diff(samples) ** 2)))
            numbers[channel] = float(np.log(change)) if change > 0.0 else np.nan
    return numbers


def _distances(values: Array) -> Array:
    """Distances from the median in robust standard deviations; zero if there are few values."""
    finite = values[np.isfinite(values)]
    if finite.size < _FEWEST:
        return np.zeros(values.size)
    middle = np.median(finite)
    spread = _TO_DEVIATION * float(np.median(np.abs(finite - middle)))
    away = np.nan_to_num(np.abs(values - middle))
    return np.asarray(np.divide(away, spread, out=np.zeros(values.size), where=spread > 0.0))


def _remark(channel: Channel, distance: float) -> Issue:
    what = "the stroke is" if channel is Channel.PISTON_POSITION else f"the changes of {channel} are"
    text = f"{what} {distance:.1f} standard deviations from the median of its group"
    return Issue(text, channel, kind="outlier")
