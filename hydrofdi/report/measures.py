"""Measured records as CSV, JSON and Parquet, written record by record."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.indicators.measuring import MeasuredOutput, RecordMeasures
from hydrofdi.tables.table import Column, Table, library, plain, quantity

_LEADING = ("record_id", "source", "group", "label", "status")
OWN = {
    "csv": re.compile(",".join(_LEADING).encode()),
    "json": re.compile(rb'\{"indicators": \[\{"name": '),
    "parquet": re.compile(rb"PAR1.*record_id", re.DOTALL),
}
"""Form → first and last bytes of its files."""

_ROWS = 1_000
"""Number of records in memory while a table is written."""


def measures_table(
    columns: Sequence[MeasuredOutput], records: Sequence[RecordMeasures], notes: Sequence[str] = ()
) -> Table:
    """A row for each record; people read an error in the unit of its estimate."""
    texts = {name: [getattr(record, name) for record in records] for name in _LEADING}
    hidden = {"source", *(["status"] if {*texts["status"]} <= {"ok"} else [])}
    lead = [
        Column(name, own, title=name.removesuffix("_id"), is_text=True, is_shown=name not in hidden)
        for name, own in texts.items()
    ]
    numbers: dict[str, Column] = {}
    for column in columns:
        nothing = np.full(tuple(column.output.dims.values()), np.nan)
        held = [record.values.get(column.name, nothing) for record in records]
        values = np.array(held, dtype=float).reshape(len(records), *nothing.shape)
        if column.output.dims:
            dims = tuple(f"{column.label}.{dim}" for dim in column.output.dims)
            numbers[column.name] = Column(column.name, values, column.unit, dims=dims)
            continue
        estimate = numbers.get(column.name.removesuffix("_error"))
        sizes = [] if estimate is None or estimate.unit != column.unit else estimate.array.tolist()
        has_any = bool(np.isfinite(values).any())
        numbers[column.name] = quantity(column.name, values, column.unit, sizes=sizes, is_shown=has_any)
    why = ["; ".join(f"{label}: {reason}" for label, reason in record.reasons.items()) for record in records]
    reasons = Column("reasons", why, is_text=True, is_shown=False)
    return Table((*lead, *numbers.values(), reasons), notes=tuple(notes), row="record", n_lead=len(lead))


def upright(table: Table, columns: Sequence[MeasuredOutput]) -> Table:
    """Few records beside each other, a row for each number with its error: scores, fits, then the others."""
    names, *others = table.shown[: table.n_shown_lead]
    numbers = {each.name: each for each in table.shown[table.n_shown_lead :]}
    errors = {name: numbers.pop(f"{name}_error") for name in [*numbers] if f"{name}_error" in numbers}
    outputs = sorted(columns, key=lambda each: (not each.output.is_score, not each.output.is_fit))
    rows = [*others, *(numbers[output.name] for output in outputs if output.name in numbers)]

    def text(of: Column, row: int) -> str:
        error = errors.get(of.name)
        return of.text_of(row) + (f" ± {error.text_of(row)}" if error else "")

    records = (
        Column(names.text_of(row), [text(each, row) for each in rows], is_text=True)
        for row in range(len(table))
    )
    headings = Column("number", [row.heading for row in rows], is_text=True)
    return Table((headings, *records), notes=table.notes)


def _files(columns: Sequence[MeasuredOutput], records: Iterable[RecordMeasures]) -> Iterator[Table]:
    """Tables of as many records as memory holds at once: a column for each number, units in names."""
    records = iter(records)
    some = [*islice(records, _ROWS)]
    while True:
        flat = (each for column in measures_table(columns, some).content for each in column.flat)
        yield Table(tuple(replace(each, name=each.name + _suffix(each.unit)) for each in flat))
        if not (some := [*islice(records, _ROWS)]):
            return


def csv_lines(columns: Sequence[MeasuredOutput], records: Iterable[RecordMeasures]) -> Iterator[str]:
    """Lines of CSV; an empty field where a number is missing."""
    for position, table in enumerate(_files(columns, records)):
        yield table.to_csv(header=position == 0)


def json_parts(columns: Sequence[MeasuredOutput], records: Iterable[RecordMeasures]) -> Iterator[str]:
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


def write_parquet(path: Path, columns: Sequence[MeasuredOutput], records: Iterable[RecordMeasures]) -> None:
    """Write the columns of the CSV as Parquet."""
    parquet, pyarrow = library("pyarrow.parquet"), library("pyarrow")
    first, *_ = _files(columns, [])
    kinds = [(each.name, pyarrow.string() if each.is_text else pyarrow.float64()) for each in first.content]
    with parquet.ParquetWriter(path, pyarrow.schema(kinds)) as writer:
        for table in _files(columns, records):
            writer.write_table(pyarrow.table(table.flat(), schema=writer.schema))


def _record(columns: Sequence[MeasuredOutput], record: RecordMeasures) -> dict[str, Any]:
    whole: dict[str, Any] = {name: getattr(record, name) for name in _LEADING}
    whole |= {"group": record.group or None, "label": record.label or None}
    whole["values"] = {column.name: plain(record.values.get(column.name)) for column in columns}
    doubts = {doubt.where: doubt.message for doubt in record.doubts}
    more = {"reasons": record.reasons, "doubts": doubts}
    return whole | {name: texts for name, texts in more.items() if texts}


def _suffix(unit: str) -> str:
    """A unit as the end of a header, such as ``_L_per_min``."""
    if unit in ("", "1"):
        return ""
    words = f"per {unit[2:]}" if unit.startswith("1/") else unit.replace("/", " per ")
    return "_" + re.sub(r"[ *·]+", "_", re.sub(r"[\^()]", "", words))
