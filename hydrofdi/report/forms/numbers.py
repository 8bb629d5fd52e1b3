"""Numbers and lines for programs."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


def finite(value: float) -> float | None:
    """The value, or None if it is NaN or infinite."""
    return value if math.isfinite(value) else None


_BEGINNINGS_OF_FORMULAS = ("=", "+", "-", "@", "\t", "\r")


def plain(value: Any) -> Any:
    """Data with None in place of numbers that do not exist; arrays and tuples as lists."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def row_records(columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Rows of columns for JSON."""
    values = map(plain, columns.values())
    return [dict(zip(columns, row, strict=True)) for row in zip(*values, strict=True)]


def csv_lines(rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Rows as CSV; None is an empty field, and text that a spreadsheet would calculate gets an apostrophe."""
    line = io.StringIO()
    writer = csv.writer(line, lineterminator="\n")
    for row in rows:
        writer.writerow(_inert(cell) for cell in row)
        yield line.getvalue()
        line.seek(0)
        line.truncate()


def _inert(cell: Any) -> Any:
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(_BEGINNINGS_OF_FORMULAS) else cell
