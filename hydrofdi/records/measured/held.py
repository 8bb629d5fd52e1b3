"""Records of arrays in memory, read like the columns of a measured file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array, RecordBatch, RejectedRecord
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.batching import batched
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.formats.table import Table
from hydrofdi.records.measured.forming import Forming, MeasuredRecord
from hydrofdi.records.measured.source import described
from hydrofdi.settings.yaml_source import Source


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
