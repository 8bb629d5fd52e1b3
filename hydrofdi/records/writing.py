"""Records as files for other programs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records.batch import Array, Channel, RecordBatch
from hydrofdi.records.columns import channel_called, scaled
from hydrofdi.records.opening import parquet_library
from hydrofdi.settings.messages import counted
from hydrofdi.units import parse_unit, zero_of


@dataclass(frozen=True)
class WrittenColumn:
    """Samples under the symbol of a channel, or ``time``, with their unit."""

    name: str
    unit: str
    values: Array

    @property
    def title(self) -> str:
        """Header of the column, such as ``P1 [Pa]``."""
        return titled(self.name, self.unit)


def titled(name: str, unit: str) -> str:
    """The header with a unit, as readers of measured files and of streams expect it."""
    return f"{name} [{unit}]"


@dataclass(frozen=True)
class Selection:
    """Which channels are written, in this order, all if empty; and in which units, SI if not stated."""

    channels: Sequence[Channel]
    units: Mapping[Channel, str]

    def columns(self, batch: RecordBatch, row: int) -> Iterator[WrittenColumn]:
        """Time and the channels of a record."""
        yield WrittenColumn("time", "s", batch.time)
        for channel in self.channels or batch.channels:
            if channel not in batch.channels:
                has = ", ".join(each.symbol for each in batch.channels)
                raise DataError(f"{batch.sources[row]}: has no {channel.symbol} ({channel}); it has {has}")
            own, values = batch.unit(channel), batch[channel][row]
            if channel in batch.relative:
                yield WrittenColumn(channel.symbol, "-" if own == "1" else own, values)
                continue
            unit = self.units.get(channel, own)
            factor = parse_unit(own).factor / parse_unit(unit).factor
            zero = zero_of(unit)
            yield WrittenColumn(channel.symbol, unit, scaled(values - zero if zero else values, factor))


def selection(channels: Collection[str], units: Collection[str]) -> Selection:
    """A selection from symbols or names of channels, and units, each for the channels of its dimension."""
    chosen, of = tuple(dict.fromkeys(map(channel_called, channels))), dict[Channel, str]()
    for unit in units:
        try:
            exponents = parse_unit(unit).exponents
        except ValueError as error:
            raise ConfigError(f"unit: {error}") from None
        fitting = [each for each in chosen or Channel if parse_unit(each.unit).exponents == exponents]
        if not fitting:
            symbols = ", ".join(channel.symbol for channel in chosen or Channel)
            raise ConfigError(f"unit {unit!r} fits none of the channels {symbols}")
        if fitting[0] in of:
            raise ConfigError(
                f"units {of[fitting[0]]} and {unit} both fit {fitting[0].symbol}; give one of them"
            )
        of |= dict.fromkeys(fitting, unit)
    return Selection(chosen, of)


_ROWS_AT_ONCE = 100_000


def write_csv(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Rows under a header such as ``time [s],P1 [Pa]``; a missing number is an empty field."""
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(",".join(column.title for column in columns) + "\n")
        for first in range(0, columns[0].values.size, _ROWS_AT_ONCE):
            parts = (column.values[first : first + _ROWS_AT_ONCE].tolist() for column in columns)
            file.writelines(",".join(map(_text, row)) + "\n" for row in zip(*parts, strict=True))


def write_parquet(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Columns named as in CSV; their units are also metadata ``units`` of the fields."""
    parquet = parquet_library()
    import pyarrow

    fields = [
        pyarrow.field(column.title, pyarrow.float64(), metadata={"units": column.unit}) for column in columns
    ]
    arrays = [pyarrow.array(column.values) for column in columns]
    parquet.write_table(pyarrow.table(arrays, schema=pyarrow.schema(fields)), path)


def write_mat(path: Path, columns: Sequence[WrittenColumn]) -> None:
    """Column vectors ``time``, ``P1``, … and a structure ``units`` with the unit of each; MAT version 5."""
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    content: dict[str, Any] = {column.name: np.ascontiguousarray(column.values) for column in columns}
    units = {column.name: column.unit for column in columns}
    try:
        savemat(str(path), content | {"units": units}, appendmat=False, oned_as="column", do_compression=True)
    except MatWriteError:
        raise DataError(
            f"{counted(columns[0].values.size, 'sample')} are too many for MAT; write Parquet"
        ) from None


WRITERS = {"csv": write_csv, "parquet": write_parquet, "mat": write_mat}
"""Form, which is also the suffix → its writer."""

OWN = {
    "csv": re.compile(rb"time \[s\],"),
    "parquet": re.compile(rb"PAR1"),
    "mat": re.compile(rb"MATLAB 5\.0 MAT-file"),
}
"""Form → first bytes of its files."""


def _text(value: float) -> str:
    return "" if value != value else repr(value)
