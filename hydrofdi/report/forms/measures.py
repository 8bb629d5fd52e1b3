"""Measured records as CSV, JSON and Parquet, written record by record."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import ReportError
from hydrofdi.indicators.record_measures import Column, RecordMeasures
from hydrofdi.report.forms import separated
from hydrofdi.report.forms.numbers import finite

_LEADING, _LAST = ("record_id", "source", "group", "label", "status"), "reasons"
OWN = {
    "csv": re.compile(",".join(_LEADING).encode()),
    "json": re.compile(rb'\{"indicators": \[\{"name": '),
    "parquet": re.compile(rb"PAR1.*record_id", re.DOTALL),
}
"""Form → first and last bytes of its files."""

_ROW_GROUP = 10_000
"""Number of records in memory while Parquet is written."""


def headers(columns: Sequence[Column]) -> list[str]:
    """Headers of a table: names with their units; one for each number of an array."""
    names = [
        f"{column.name}{'.' * bool(index)}{'.'.join(map(str, index))}{_suffix(column.unit)}"
        for column in columns
        for index in np.ndindex(*column.output.dims.values())
    ]
    return [*_LEADING, *names, _LAST]


def csv_lines(columns: Sequence[Column], records: Iterable[RecordMeasures]) -> Iterator[str]:
    """Lines of CSV; an empty field where a number is missing."""
    return separated.csv_lines(chain([headers(columns)], (_row(columns, record) for record in records)))


def json_parts(columns: Sequence[Column], records: Iterable[RecordMeasures]) -> Iterator[str]:
    """Parts of one JSON object: the indicators, then a line for each record."""
    indicators = [
        {"name": column.name, "unit": column.unit, "channels": list(column.channels)} for column in columns
    ]
    yield f'{{"indicators": {json.dumps(indicators)},\n"records": ['
    between = "\n"
    for record in records:
        yield between + json.dumps(_record(columns, record), allow_nan=False)
        between = ",\n"
    yield "\n]}\n"


def write_parquet(path: Path, columns: Sequence[Column], records: Iterable[RecordMeasures]) -> None:
    """Write the columns of the CSV as Parquet.

    Raises
    ------
    ReportError
        The extra is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise ReportError("Parquet needs the extra: pip install 'hydrofdi[parquet]'") from None
    names = headers(columns)
    texts = {*_LEADING, _LAST}
    kinds = [(name, pyarrow.string() if name in texts else pyarrow.float64()) for name in names]
    rows = (_row(columns, record) for record in records)
    with parquet.ParquetWriter(path, pyarrow.schema(kinds)) as writer:
        while group := list(islice(rows, _ROW_GROUP)):
            fields = dict(zip(names, zip(*group, strict=True), strict=True))
            writer.write_table(pyarrow.table(fields, schema=writer.schema))


def _row(columns: Sequence[Column], record: RecordMeasures) -> list[Any]:
    row: list[Any] = [record.record_id, record.source, record.group, record.label, record.status]
    for column in columns:
        values = record.values.get(column.name)
        row += [None] * column.size if values is None else map(finite, np.ravel(values).tolist())
    return [*row, "; ".join(f"{label}: {reason}" for label, reason in record.reasons.items())]


def _record(columns: Sequence[Column], record: RecordMeasures) -> dict[str, Any]:
    values = {column.name: _plain(record, column) for column in columns}
    whole: dict[str, Any] = {
        "record_id": record.record_id,
        "source": record.source,
        "group": record.group or None,
        "label": record.label or None,
        "status": record.status,
        "values": values,
    }
    doubts = {doubt.name: doubt.text for doubt in record.doubts}
    more = {"reasons": record.reasons, "doubts": doubts}
    return whole | {name: texts for name, texts in more.items() if texts}


def _plain(record: RecordMeasures, column: Column) -> Any:
    """Numbers of an output, in lists if it has dimensions."""
    if column.name not in record.values:
        return None
    return _nested(np.asarray(record.values[column.name]).tolist())


def _nested(values: Any) -> Any:
    return [_nested(item) for item in values] if isinstance(values, list) else finite(values)


def _suffix(unit: str) -> str:
    """A unit as the end of a header, such as ``_L_per_min``."""
    if unit == "1":
        return ""
    words = f"per {unit[2:]}" if unit.startswith("1/") else unit.replace("/", " per ")
    return "_" + re.sub(r"[ *·]+", "_", re.sub(r"[\^()]", "", words))
