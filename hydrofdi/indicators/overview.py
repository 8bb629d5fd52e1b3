"""Indicators as users give them, their list, and what became of the records that they measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any

from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators.record_measures import RecordMeasures
from hydrofdi.indicators.registry import Description
from hydrofdi.indicators.selection import load_indicators, make_indicators
from hydrofdi.records import Channel
from hydrofdi.settings.files import plain
from hydrofdi.settings.messages import counted
from hydrofdi.tables.table import Table


@dataclass
class Counted:
    """What became of measured records: numbers of them, the first reasons, faulty indicators and doubts."""

    n_record: int = 0
    n_rejected: int = 0
    n_empty: int = 0
    n_unmeasured: int = 0
    first_rejection: str = ""
    first_reason: str = ""
    faults: dict[str, None] = field(default_factory=dict)
    doubts: list[Issue] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come."""
        for record in records:
            self.n_record += 1
            self.n_rejected += record.is_rejected
            self.n_empty += not (record.is_rejected or record.has_numbers)
            self.faults |= dict.fromkeys(record.faults.values())
            self.doubts += record.doubts
            others = ((label, text) for label, text in record.reasons.items() if label not in record.faults)
            label, reason = next(others, ("", record.status))
            if record.is_rejected:
                self.first_rejection = self.first_rejection or f"{record.record_id}: {reason}"
            elif label:
                self.n_unmeasured += 1
                self.first_reason = self.first_reason or f"{label}: {reason}"
            yield record

    @property
    def is_lacking(self) -> bool:
        """Whether records could not be measured, or an indicator failed."""
        return bool(self.n_rejected or self.n_empty or self.faults)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records without numbers."""
        yield from (f"failed: {fault}" for fault in self.faults)
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_rejected:
            yield f"rejected: {self.n_rejected:,} {of}; {self.first_rejection}"
        if self.n_empty:
            yield f"without any number: {self.n_empty:,} {of}"


Indicators = str | PathLike[str] | Sequence[str] | Mapping[str, Any]
"""``"dwt,ring_down"``, ``"all"``, a list of names, a YAML file, or label → options."""


def indicators_of(given: Indicators) -> dict[str, Any]:
    """Label → indicator."""
    if isinstance(given, int | float):
        raise ConfigError(f"indicators: found {given!r}; is it meant as sampling_frequency={given!r}?")
    if isinstance(given, str | PathLike):
        return load_indicators(fspath(given))
    return make_indicators(plain(given))


def indicators_table(described: Sequence[Description], *, with_sources: bool = True) -> Table:
    """A row for each indicator."""
    symbols = [" ".join(Channel(name).symbol for name in each.channels) for each in described]
    columns: dict[str, list[Any]] = {
        "name": [each.name for each in described],
        "summary": [each.summary for each in described],
        "channels": symbols,
        "outputs": [len(each.outputs) for each in described],
        "cost": [each.cost for each in described],
    }
    sources = {"source": [each.source for each in described]} if with_sources else {}
    return Table.of(columns | sources, row="indicator")
