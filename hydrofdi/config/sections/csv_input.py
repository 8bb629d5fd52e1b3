"""The user's own input as CSV: times and values, each of which holds until the next time.

A configuration holds the contents, not the path, as a text of one form::

    # drive.csv
    time [s],voltage [V]
    0.0,2.0
    0.5,-2.0

The first line is a name for people; everything else is the input's identity.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo

from hydrofdi.errors import DataError
from hydrofdi.settings.files import read_text
from hydrofdi.settings.messages import counted
from hydrofdi.units import parse_si, parse_unit

MOST_ROWS = 100_000
"""Rows that a file may have."""

_MOST_BYTES = 100 * MOST_ROWS
_UNITS = {"voltage": "V", "position": "m"}


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Values of a ``voltage`` [V] or ``position`` [m] that hold from their times [s] on, (n_row,)."""

    quantity: str
    times: NDArray[np.float64]
    values: NDArray[np.float64]


def input_contents(given: str, info: ValidationInfo) -> str:
    """Contents of a CSV file, or of a text of lines; stored experiments (with a context) name no file."""
    if "\n" in given:
        first = given.partition("\n")[0]
        return held_text(first.removeprefix("# ") if first.startswith("# ") else "text", given)
    if info.context is not None:
        raise ValueError(f"{given!r} is a path; only experiment files and settings name files")
    path, kind = Path(given), "an input of times and values"
    if path.exists() and not path.is_dir() and (not path.is_file() or path.stat().st_size > _MOST_BYTES):
        raise ValueError(f"{path}: is no file, or larger than the {_MOST_BYTES / 1e6:g} MB of an input")
    return held_text(path.name, read_text(path, kind).removeprefix("\ufeff"), given)


@lru_cache(maxsize=64)
def held_text(name: str, text: str, place: str = "text") -> str:
    """A CSV text in the form that a configuration holds, with a name for people, and a place for messages."""
    rows = parse_rows(text, place)
    pairs = zip(rows.times.tolist(), rows.values.tolist(), strict=True)
    lines = [f"# {' '.join(name.split())}", f"time [s],{rows.quantity} [{_UNITS[rows.quantity]}]"]
    lines += [f"{time!r},{value!r}" for time, value in pairs]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def parse_rows(text: str, place: str = "text") -> HeldRows:
    """The rows of a CSV text."""
    # only an experiment with a file loads the reader of measured files
    from hydrofdi.records.columns import short_name
    from hydrofdi.records.description import FormatConfig, known_unit
    from hydrofdi.records.text import TextTable

    def require(is_met: bool, message: str, row: int = -1) -> None:
        if not is_met:
            raise ValueError(f"{table.row_place(row)}: {message}")

    try:
        table = TextTable(place, FormatConfig(decimal="."), lambda: iter([[*text.splitlines(), ""]]))
        columns = [table.numbers(n) for n in range(len(table.titles))]
        units = [table.unit(n) for n in range(len(table.titles))]
    except DataError as error:
        raise ValueError(str(error).partition(";")[0]) from None  # the rest tells of descriptions
    n_row, n_column = columns[0].size, len(columns)
    if not 1 <= n_row <= MOST_ROWS:
        raise ValueError(f"{place}: contains {counted(n_row, 'row')}; needs 1 to {MOST_ROWS}")
    widest = int(np.argmax(np.isfinite(columns[-1])))
    require(n_column == 2, f"expected two columns, time and voltage; found {n_column}", widest)
    is_cut = any(remark.kind == "truncated" for remark in table.remarks)
    require(not is_cut, "expected two columns, time and voltage", n_row)
    named = "position" if short_name(table.titles[1]) == "position" else "voltage"
    units = [units[0] or "s", units[1] or _UNITS[named]]
    dimensions = [found and found.exponents for found in map(known_unit, units)]
    fitting = (name for name, own in _UNITS.items() if parse_unit(own).exponents == dimensions[1])
    quantity = next(fitting, "")
    require(dimensions[0] == parse_unit("s").exponents, f"the unit {units[0]!r} is not one of time")
    require(bool(quantity), f"the second column is a voltage or a position, not in {units[1]!r}")
    is_finite = np.isfinite(columns[0]) & np.isfinite(columns[1])
    require(bool(is_finite.all()), "needs finite numbers", int(np.argmin(is_finite)))
    for column, unit in enumerate(units):
        if parse_unit(unit).factor != 1:
            numbers = columns[column].tolist()
            columns[column] = np.array([parse_si(f"{number!r} {unit}") for number in numbers])
    times, values = columns[0] + 0.0, columns[1] + 0.0  # no zero is negative
    is_rising = np.diff(times, prepend=min(times[0], 0.0) - 1.0) > 0.0
    is_rising[0] &= times[0] <= 0.0
    row = int(np.argmin(is_rising))
    message = f"times rise strictly, from zero or less; found {times[row]:g} s"
    require(bool(is_rising.all()), message, row)
    return HeldRows(quantity, times, values)


@lru_cache(maxsize=64)
def digest(text: str) -> str:
    """What a held text is, without its name: ``sha256:…``."""
    contents = text.partition("\n")[2]
    return f"sha256:{hashlib.sha256(contents.encode()).hexdigest()}"


def without_contents(data: Any) -> Any:
    """Plain data with every held CSV text replaced by its name, size and digest."""
    if isinstance(data, dict):
        return {key: without_contents(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return type(data)(without_contents(value) for value in data)
    if isinstance(data, str) and data.startswith("# ") and "\ntime [s]," in data:
        name = data.partition("\n")[0].removeprefix("# ")
        n_row = data.count("\n") - 2
        return f"{name} ({n_row} row{'s' if n_row > 1 else ''}, {digest(data)[7:15]})"
    return data
