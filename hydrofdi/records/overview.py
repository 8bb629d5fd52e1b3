"""A first look at unknown records: what they contain, and their defects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import INFERRED_SAMPLING, Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.stuck import found_period
from hydrofdi.settings.readable import readable_unit
from hydrofdi.units import convert, parse_unit

_WITHOUT_SCALE = ("counts", "1")
"""Units of channels that have no scale."""

_EXAMPLES = 3
"""Examples that are kept of each kind of remark."""


@dataclass
class Range:
    """Values of a channel over all records; in SI, or in counts.

    Attributes
    ----------
    unit : str
        Unit of the values.
    units : set of str
        Units of the channel in the files.
    n_record, n_sample : int
        Number of records with the channel, and of finite samples in them.
    least, largest, total : float
        Minimum, maximum and sum of these samples.
    """

    unit: str
    units: set[str] = field(default_factory=set)
    n_record: int = 0
    n_sample: int = 0
    least: float = np.inf
    largest: float = -np.inf
    total: float = 0.0

    @property
    def mean(self) -> float:
        """Mean over all finite samples; NaN if there are none."""
        return self.total / self.n_sample if self.n_sample else np.nan

    @property
    def shown_unit(self) -> str:
        """Unit for display: the unit of the files, else one that suits the size of the values."""
        if self.unit not in _WITHOUT_SCALE and len(self.units) == 1:
            (stated,) = self.units
            if parse_unit(stated) != parse_unit(self.unit):
                return stated
        return readable_unit(self.unit, max(abs(self.least), abs(self.largest)))

    def shown(self, value: float) -> float:
        """A value in `shown_unit`."""
        return value if self.shown_unit == self.unit else convert(value, self.shown_unit)

    def add(self, samples: Array) -> None:
        """Add the samples of some records, shape (n_record, n_time)."""
        finite = samples[np.isfinite(samples)]
        self.n_record += len(samples)
        self.n_sample += finite.size
        self.total += float(finite.sum())
        self.least = min(self.least, float(finite.min(initial=np.inf)))
        self.largest = max(self.largest, float(finite.max(initial=-np.inf)))


@dataclass
class Finding:
    """A kind of remark: the number of records with it, and a few examples."""

    n_record: int = 0
    is_rejection: bool = False
    examples: list[tuple[str, str]] = field(default_factory=list)

    def add(self, record_id: str, remark: Issue) -> None:
        """Count a record."""
        self.n_record += 1
        if len(self.examples) < _EXAMPLES:
            self.examples.append((record_id, remark.message))


@dataclass
class Overview:
    """What a source contains.

    Attributes
    ----------
    name : str
    n_record, n_rejected : int
        Number of records that can be measured, and of rejected records.
    lengths : counter of int
        Number of samples → number of records.
    sampling_frequencies : counter of float
        [Hz] → number of records.
    drive_periods : counter of (float or None)
        [s] → number of records, known or found in u; None if there is none.
    groups, labels : counter of str
    channels : dict of Channel to Range
    findings : dict of str to Finding
        Kind of a remark, or of a rejection → its records.
    example : RecordBatch or None
        The requested record, or the first.
    """

    name: str
    n_record: int = 0
    n_rejected: int = 0
    lengths: Counter[int] = field(default_factory=Counter)
    sampling_frequencies: Counter[float] = field(default_factory=Counter)
    drive_periods: Counter[float | None] = field(default_factory=Counter)
    groups: Counter[str] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    channels: dict[Channel, Range] = field(default_factory=dict)
    findings: dict[str, Finding] = field(default_factory=dict)
    example: RecordBatch | None = None

    @property
    def is_inferred(self) -> bool:
        """Whether a sampling frequency is inferred, not documented."""
        return INFERRED_SAMPLING in self.findings

    def add(self, batch: RecordBatch) -> None:
        """Add a batch."""
        n_record = batch.n_record
        self.n_record += n_record
        self.n_rejected += len(batch.rejected)
        if n_record:
            self.lengths[batch.n_time] += n_record
            self.sampling_frequencies[batch.sampling_frequency] += n_record
            self.drive_periods.update(found_period(batch, row) for row in range(n_record))
        self.groups.update(filter(None, batch.groups))
        self.labels.update(filter(None, batch.labels or ()))
        for channel, samples in batch.channels.items():
            found = self.channels.setdefault(channel, Range(batch.unit(channel)))
            found.add(samples)
            found.units |= batch.units.get(channel, frozenset())
        for record_id, remarks in zip(batch.record_ids, batch.remarks, strict=True):
            for remark in {remark.kind: remark for remark in reversed(remarks)}.values():
                self.findings.setdefault(remark.kind, Finding()).add(record_id, remark)
        for rejected in batch.rejected:
            finding = self.findings.setdefault(rejected.remark.kind, Finding(is_rejection=True))
            finding.add(rejected.record_id, rejected.remark)


def look_at(sources: Sequence[RecordSource], record_id: str | None = None) -> Overview:
    """The overview of some sources, which are read once.

    Parameters
    ----------
    sources : sequence of RecordSource
    record_id : str, optional
        The record that is kept as the example; the beginning of its name is enough.

    Raises
    ------
    DataError
        There is no such record, or a measured file cannot be used.
    StoreError
        A stored file cannot be read.
    """
    overview = Overview(", ".join(source.name for source in sources))
    for batch in chain.from_iterable(source.batches(labels=True) for source in sources):
        overview.add(batch)
        for rejected in batch.rejected:
            if record_id is not None and rejected.record_id == record_id:
                text = f"record {record_id} is rejected: {rejected.remark.message}"
                raise DataError(f"{overview.name}: {text}")
        if batch.n_record and (record_id in batch.record_ids or overview.example is None):
            row = _row(batch, record_id)
            overview.example = overview.example if row is None else batch.rows([row])
    if record_id is not None and overview.example is None:
        raise DataError(f"{overview.name}: has no record {record_id!r}; 'hydrofdi measure' lists them")
    return overview


def _row(batch: RecordBatch, record_id: str | None) -> int | None:
    """Row of a record, or else of the first one whose name begins with `record_id`."""
    if record_id in batch.record_ids:
        return batch.record_ids.index(record_id)
    names = enumerate(batch.record_ids)
    return next((row for row, name in names if name.startswith(record_id or "")), None)
