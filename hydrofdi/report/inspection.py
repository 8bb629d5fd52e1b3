"""What records contain, and their defects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.records import INFERRED_SAMPLING, Array, Channel, RecordBatch
from hydrofdi.records.recording import found_period
from hydrofdi.settings.messages import convert, readable_unit
from hydrofdi.tables.answer import Answer, Piece, Strong
from hydrofdi.tables.table import Table, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_EXAMPLES, _MOST_GROUPS = 3, 12
"""Examples that are kept of each kind of remark; most groups and labels that are listed."""


@dataclass
class Range:
    """Values of a channel over all records [in `unit`, SI or counts]; ``units`` are those in the files."""

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
        if self.unit != "counts" and len(self.units) == 1:
            (stated,) = self.units
            if convert(1.0, stated) != 1.0:
                return stated
        return readable_unit(self.unit, max(abs(self.least), abs(self.largest)))

    def shown(self, value: float) -> float:
        """A value in `shown_unit`."""
        return convert(value, self.shown_unit, self.unit)

    def add(self, samples: Array) -> None:
        """Add the samples of some records, shape (n_record, n_time)."""
        finite = samples[np.isfinite(samples)]
        self.n_record += len(samples)
        self.n_sample += finite.size
        self.total += float(finite.sum())
        self.least = min(self.least, float(finite.min(initial=np.inf)))
        self.largest = max(self.largest, float(finite.max(initial=-np.inf)))


@dataclass
class RemarkCount:
    """A kind of remark: the number of records with it, and a few examples."""

    n_record: int = 0
    is_rejection: bool = False
    examples: list[tuple[str, str]] = field(default_factory=list)

    def add(self, record_id: str, text: str) -> None:
        """Count a record."""
        self.n_record += 1
        if len(self.examples) < _EXAMPLES:
            self.examples.append((record_id, text))


@dataclass(repr=False)
class Inspection(Answer):
    """Contents and defects of records, as `hydrofdi.inspect` returns them.

    Attributes
    ----------
    n_record, n_rejected : int
        Number of records that can be measured, and of rejected records.
    lengths, sampling_frequencies, drive_periods, groups, labels : counter
        Number of samples, [Hz], [s] (known or found in u; None if there is none), names → number of records.
    ranges : dict of Channel to Range
    remarked : dict of str to Finding
        Kind of a remark, or of a rejection → its records.
    example : RecordBatch or None
        The requested record, or the first.
    assumptions : tuple of str
        A sentence on the constants of the actuator that nobody stated; empty if all are stated.
    """

    name: str
    n_record: int = 0
    n_rejected: int = 0
    lengths: Counter[int] = field(default_factory=Counter)
    sampling_frequencies: Counter[float] = field(default_factory=Counter)
    drive_periods: Counter[float | None] = field(default_factory=Counter)
    groups: Counter[str] = field(default_factory=Counter)
    labels: Counter[str] = field(default_factory=Counter)
    ranges: dict[Channel, Range] = field(default_factory=dict)
    remarked: dict[str, RemarkCount] = field(default_factory=dict)
    example: RecordBatch | None = None
    assumptions: tuple[str, ...] = ()

    @property
    def is_inferred(self) -> bool:
        """Whether a sampling frequency is inferred, not documented."""
        return INFERRED_SAMPLING in self.remarked

    @property
    def remarks(self) -> dict[str, int]:
        """Kind of a remark → number of records that have it."""
        return {kind: finding.n_record for kind, finding in self.remarked.items()}

    def add(self, batch: RecordBatch, wanted: str | None = None) -> None:
        """Add a batch; its record of the `wanted` name, or beginning of it, is the example."""
        n_record = batch.n_record
        if n_record and (wanted in batch.record_ids or self.example is None):
            row = _row(batch, wanted)
            self.example = self.example if row is None else batch.rows([row])
        self.n_record += n_record
        self.n_rejected += len(batch.rejected)
        if n_record:
            self.lengths[batch.n_time] += n_record
            self.sampling_frequencies[batch.sampling_frequency] += n_record
            self.drive_periods.update(found_period(batch, row) for row in range(n_record))
        self.groups.update(filter(None, batch.groups))
        self.labels.update(filter(None, batch.labels or ()))
        for channel, samples in batch.channels.items():
            found = self.ranges.setdefault(channel, Range(batch.unit(channel)))
            found.add(samples)
            found.units |= batch.units.get(channel, frozenset())
        for record_id, remarks in zip(batch.record_ids, batch.remarks, strict=True):
            for kind in dict.fromkeys(remark.kind for remark in remarks):
                texts = [remark.message for remark in remarks if remark.kind == kind]
                self.remarked.setdefault(kind, RemarkCount()).add(record_id, "; ".join(texts))
        for rejected in batch.rejected:
            finding = self.remarked.setdefault(rejected.remark.kind, RemarkCount(is_rejection=True))
            finding.add(rejected.record_id, rejected.remark.message)

    def to_dict(self) -> dict[str, Any]:
        """What ``hydrofdi inspect --json`` prints."""
        rate_is = {"is": "inferred" if self.is_inferred else "given"}
        record: dict[str, Any] = plain({
            "source": self.name,
            "records": self.n_record,
            "rejected": self.n_rejected,
            "samples": _counted("samples", self.lengths),
            "sampling_frequencies_Hz": [
                each | rate_is for each in _counted("frequency", self.sampling_frequencies)
            ],
            "drive_periods_s": _counted("period", self.drive_periods),
            "channels": {
                channel: {"unit": each.unit, "records": each.n_record}
                | {"min": each.least, "mean": each.mean, "max": each.largest}
                for channel, each in self.ranges.items()
            },
            "groups": self.groups,
            "labels": self.labels,
            "findings": {
                kind: {
                    "records": finding.n_record,
                    "rejects": finding.is_rejection,
                    "examples": [{"record_id": name, "text": text} for name, text in finding.examples],
                }
                for kind, finding in self.remarked.items()
            },
            "assumptions": self.assumptions,
        })  # fmt: skip
        return record

    @property
    def channels(self) -> Table:
        """A row for each channel: its range in the ``unit`` of the files, or in one that suits it."""
        found, ends = self.ranges.values(), {"min": "least", "mean": "mean", "max": "largest"}
        columns: dict[str, list[Any]] = {
            "channel": [channel.value for channel in self.ranges],
            "unit": [each.shown_unit for each in found],
            **{name: [each.shown(getattr(each, end)) for each in found] for name, end in ends.items()},
            "records": [each.n_record for each in found],
        }
        return Table.of(columns, n_lead=2, title="Channels")

    @property
    def findings(self) -> Table:
        """A row for each kind of remark: ``records`` that have it, and one as an ``example``."""
        found = self.remarked.items()
        columns: dict[str, list[Any]] = {
            "remark": [f"{kind}{' (rejected)' * each.is_rejection}" for kind, each in found],
            "records": [each.n_record for _, each in found],
            "example": [": ".join(each.examples[0]) for _, each in found],
        }
        return Table.of(columns, title="Remarks")

    def __bool__(self) -> bool:
        return not self.n_rejected

    def parts(self) -> Iterator[Piece]:
        """What occurs, the channels, and remarks."""
        rejected = f", and {self.n_rejected:,} rejected" if self.n_rejected else ""
        rates = _counts({f"{rate:g} Hz": n for rate, n in self.sampling_frequencies.items()})
        periods = self.drive_periods.items()
        yield Strong(self.name)
        yield {
            "records": f"{self.n_record:,}{rejected}",
            "sampling": rates + (" (inferred)" if self.is_inferred else ""),
            "samples": _counts({f"{length:,}": n for length, n in self.lengths.items()}),
            "drive": _counts({f"period {each:g} s" if each else "no known period": n for each, n in periods}),
            "groups": _counts(self.groups),
            "labels": _counts(self.labels),
        }
        for table in (self.channels, self.findings):
            if len(table):
                yield from ("", table)
        if not self.remarked:
            yield from ("", "no remarks")

    def asides(self) -> Iterator[str]:
        """What is assumed of the machine."""
        return (f"note: {assumption}" for assumption in self.assumptions)

    def plot(self) -> Figure:
        """Figure of the chosen record, or of the first: its channels.

        Raises
        ------
        ReportError
            No record can be drawn.
        """
        from hydrofdi.report.figures.signals import draw_record

        if self.example is None:
            raise ReportError(f"{self.name}: has no record that can be drawn")
        return draw_record(self.example)


def _counted(name: str, counts: Mapping[Any, int]) -> list[dict[str, Any]]:
    """What occurs, and how often, for JSON: in order, what is not known first."""
    return [{name: each, "records": counts[each]} for each in sorted(counts, key=lambda each: each or 0.0)]


def _counts(counts: Mapping[Any, int]) -> str:
    """What occurs, and how often; without the number if only one thing occurs."""
    if len(counts) == 1:
        return str(next(iter(counts)))
    shown = [f"{name} ({count:,})" for name, count in list(counts.items())[:_MOST_GROUPS]]
    more = [f"and {len(counts) - _MOST_GROUPS:,} more"] if len(counts) > _MOST_GROUPS else []
    return "; ".join(shown + more)


def _row(batch: RecordBatch, record_id: str | None) -> int | None:
    """Row of a record, or else of the first one whose name begins with `record_id`."""
    if record_id in batch.record_ids:
        return batch.record_ids.index(record_id)
    names = enumerate(batch.record_ids)
    return next((row for row, name in names if name.startswith(record_id or "")), None)
