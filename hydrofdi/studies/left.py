"""Records that a study of measured records leaves out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from hydrofdi.errors import ConfigError
from hydrofdi.indicators.measuring import Counted, RecordMeasures
from hydrofdi.records.copies import Copies, pairs
from hydrofdi.settings.messages import counted


@dataclass
class Left(Counted):
    """Records that are not evaluated: also repeats of another, and those without a label."""

    n_repeated: int = 0
    n_unlabelled: int = 0
    repeats: list[str] = field(default_factory=list)
    labels: set[str] = field(default_factory=set)
    _copies: Copies = field(default_factory=Copies)
    _firsts: list[RecordMeasures] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come, without those that repeat the samples of another."""
        for record in super().count(records):
            self.labels |= {record.label} - {""}
            if record.has_numbers and self._is_repeat(record):
                continue
            self.n_unlabelled += not (record.is_rejected or record.label)
            yield replace(record, sketch=None)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records that are left out."""
        yield from super().sentences()
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_repeated:
            yield f"left out: {self.n_repeated:,} {of} have the samples of another: {pairs(self.repeats)}"
        if self.n_unlabelled:
            yield f"without a label, left out: {self.n_unlabelled:,} {of}"

    def _is_repeat(self, record: RecordMeasures) -> bool:
        if record.sketch is None:
            return False
        number = self._copies.find(record.sketch)
        if number is None:
            self._firsts.append(replace(record, values={}))
            return False
        first = self._firsts[number]
        if record.label and first.label and record.label != first.label:
            if first.sketch is None or record.sketch.digest != first.sketch.digest:
                return False  # a fault may have been made of a healthy record
            raise ConfigError(
                f"{first.record_id} ({first.label}) and {record.record_id} ({record.label}) have the same"
                " samples; one of the labels is wrong"
            )
        self.n_repeated += 1
        self.repeats.append(f"{record.record_id} repeats {first.record_id}")
        return True
