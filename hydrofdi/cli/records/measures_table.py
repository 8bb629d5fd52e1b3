"""Measured records on the terminal: the first ones, in readable units."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import islice

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hydrofdi.cli.terminal import terminal
from hydrofdi.indicators.record_measures import Column, RecordMeasures
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import readable_unit
from hydrofdi.units import convert

_SHOWN = 20
"""Most records that the terminal shows."""

_LARGE = 9_999.5

_MOST_TEXT = 28
"""Most characters of a text in a row."""

_GAP, _HEADER = 2, 3
"""Blanks between columns, and lines of a heading: two for the name, one for the unit."""

_LONG_NAME = 10


def print_measures(columns: Sequence[Column], records: Iterable[RecordMeasures]) -> None:
    """Print a table of the first records for each indicator, and the number of records."""
    console, stream = terminal(), iter(records)
    shown = list(islice(stream, _SHOWN))
    n_record = len(shown) + sum(1 for _ in stream)
    for label in dict.fromkeys(column.label for column in columns):
        own = [column for column in columns if column.label == label]
        _print_indicator(console, label, own, shown)
    marked = Counter(record.status for record in shown if record.status != "ok" and not record.is_rejected)
    if marked:
        remarks = ", ".join(f"{status.replace(',', ' + ')} ({count})" for status, count in marked.items())
        console.print(f"* {remarks}; 'hydrofdi inspect' shows more")
    if n_record > len(shown):
        console.print(f"… the first {len(shown)} of {counted(n_record, 'record')}; --out FILE.csv writes all")
    elif n_record != 1:
        console.print(counted(n_record, "record"))


def _print_indicator(
    console: Console, label: str, columns: Sequence[Column], records: Sequence[RecordMeasures]
) -> None:
    console.print(Text(label, style="bold"))
    lead = [_lead(record) for record in records]
    are_measured = any(label not in record.reasons for record in records)
    leading = {column.name: column for column in columns}
    shown = [
        _texts(column, records, leading.get(column.name.removesuffix("_error"), column))
        for column in columns
        if are_measured and not column.output.dims
    ]
    for part in _parts(shown, console.width - _width(lead) - _GAP):
        first = 0 if any(texts[0] for texts in part) else 1
        table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0))
        table.add_column("record", no_wrap=True)
        for texts in part:
            table.add_column("\n".join(texts[first:_HEADER]), justify="right", no_wrap=True)
        for row in zip(lead, *(texts[_HEADER:] for texts in part), strict=True):
            table.add_row(*row)
        console.print(table)
    for column in columns:
        if column.output.dims:
            console.print(f"{column.output.name}: {counted(column.size, 'number')} for each record, in files")
    for column in columns if are_measured else ():
        if " at " in column.output.long_name and column.output.unit == "m^3/s":
            console.print(f"{column.output.name}: {column.output.long_name}", style="dim")
    for text, count in _reasons(label, records).items():
        console.print(f"not measured, {count} of {len(records)}: {text}")
    console.print()


def _parts(columns: Sequence[list[str]], room: int) -> list[list[list[str]]]:
    """Columns that fit beside each other."""
    parts: list[list[list[str]]] = [[]]
    left = room
    for texts in columns:
        width = _width(texts) + _GAP
        if parts[-1] and width > left:
            parts.append([])
            left = room
        parts[-1].append(texts)
        left -= width
    return [part for part in parts if part]


def _lead(record: RecordMeasures) -> str:
    """The first cell of a row: identity of the record, its label or group, and a mark if it has remarks."""
    known = [record.label or record.group, f"({record.status})" if record.is_rejected else ""]
    text = " ".join([_short(record.record_id), *(_short(text) for text in known if text)])
    return text if record.is_rejected or record.status == "ok" else f"{text}*"


def _short(text: str) -> str:
    return text if len(text) <= _MOST_TEXT else f"…{text[1 - _MOST_TEXT :]}"


def _texts(column: Column, records: Sequence[RecordMeasures], leading: Column) -> list[str]:
    """Name, unit and numbers of a column; an error has the unit of its estimate, the leading column."""
    unit, factor = _readable_unit(leading if leading.unit == column.unit else column, records)
    name = _two_lines(column.output.name)
    numbers = (number_text(value * factor) for value in _values(column, records))
    return [*name, "" if unit == "1" else unit, *numbers]


def _values(column: Column, records: Sequence[RecordMeasures]) -> list[float]:
    return [float(record.values.get(column.name, math.nan)) for record in records]


def _readable_unit(column: Column, records: Sequence[RecordMeasures]) -> tuple[str, float]:
    """Unit in which the terminal shows a column, and the factor from SI to this unit."""
    largest = max((abs(value) for value in _values(column, records) if math.isfinite(value)), default=0.0)
    unit = readable_unit(column.unit, largest)
    return unit, convert(1.0, unit) if unit != column.unit else 1.0


def _two_lines(name: str) -> tuple[str, str]:
    """A name, broken at an underscore if it is long."""
    breaks = [place for place, sign in enumerate(name) if sign == "_"]
    if len(name) <= _LONG_NAME or not breaks:
        return "", name
    middle = min(breaks, key=lambda place: abs(place - len(name) // 2))
    return f"{name[:middle]}_", name[middle + 1 :]


def number_text(value: float) -> str:
    """A number with four digits; a large one is rounded to an integer."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.0f}" if _LARGE <= abs(value) < 1e7 else f"{value:.4g}"


def _width(texts: Sequence[str]) -> int:
    return max((len(text) for text in texts), default=0)


def _reasons(label: str, records: Sequence[RecordMeasures]) -> dict[str, int]:
    texts = [record.reasons[label] for record in records if label in record.reasons]
    return {text: texts.count(text) for text in dict.fromkeys(texts)}
