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

from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.table import split_title
from hydrofdi.records.measured.formats.text_cells import CellError, Cells, column_numbers
from hydrofdi.settings.counting import counted
from hydrofdi.settings.validation import read_text
from hydrofdi.units import parse_quantity, parse_unit

MOST_ROWS = 100_000
"""Rows that a file may have."""

_MOST_BYTES = 100 * MOST_ROWS
_UNITS = {"voltage": "V", "position": "m"}


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Values that hold from their times on, each of shape (n_row,).

    Attributes
    ----------
    quantity : str
        ``voltage`` or ``position``.
    times : ndarray
        Strictly rising from zero or less [s].
    values : ndarray
        In V or m.
    """

    quantity: str
    times: NDArray[np.float64]
    values: NDArray[np.float64]


def input_contents(given: str, info: ValidationInfo) -> str:
    """The contents of a CSV file, or of a text of more than one line, as a configuration holds them.

    A stored experiment (a validation with a context) names no file.

    Raises
    ------
    ValueError
        The file cannot be read, or is not an input.
    """
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
    """A CSV text in the form that a configuration holds, with a name for people, and a place for messages.

    Raises
    ------
    ValueError
        The text is not an input.
    """
    rows = parse_rows(text, place)
    pairs = zip(rows.times.tolist(), rows.values.tolist(), strict=True)
    lines = [f"# {' '.join(name.split())}", f"time [s],{rows.quantity} [{_UNITS[rows.quantity]}]"]
    lines += [f"{time!r},{value!r}" for time, value in pairs]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def parse_rows(text: str, place: str = "text") -> HeldRows:
    """The rows of a CSV text.

    Raises
    ------
    ValueError
        The text is not an input; the message says in which line.
    """
    cells = Cells(place, text, FormatConfig())
    for row in range(cells.n_row):
        if len(cells.row(row)) != 2:
            message = f"expected two columns, time and voltage; found {len(cells.row(row))}"
            raise ValueError(f"{cells.place(row)}: {message}")
    first = int(cells.n_row > 0 and cells.row(0)[0].lstrip(" '")[:1].isalpha())
    if not 1 <= cells.n_row - first <= MOST_ROWS:
        raise ValueError(f"{place}: contains {counted(cells.n_row - first, 'row')}; needs 1 to {MOST_ROWS}")
    quantity, units = _header(cells) if first else ("voltage", ("s", "V"))
    times, values = (
        _numbers(cells, column, first, units[column], own)
        for column, own in enumerate(("s", _UNITS[quantity]))
    )
    falling = np.flatnonzero(np.diff(times, prepend=min(times[0], 0.0) - 1.0) <= 0.0)
    if times[0] > 0.0 or falling.size:
        row = falling[0] if times[0] <= 0.0 else 0
        raise ValueError(
            f"{cells.place(first + row)}: times rise strictly, from zero or less; found {times[row]:g} s"
        )
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


def _header(cells: Cells) -> tuple[str, tuple[str, str]]:
    """Quantity of the second column, and the units of both."""
    (_, time), (name, unit) = map(split_title, cells.row(0))
    unit = unit or ("m" if name.strip().lower() == "position" else "V")
    for quantity, own in _UNITS.items():
        try:
            parse_quantity(f"0 {time or 's'}", "s")
            if parse_unit(unit).exponents == parse_unit(own).exponents:
                return quantity, (time or "s", unit)
        except ValueError as error:
            raise ValueError(f"{cells.place(0)}: {error}") from None
    raise ValueError(f"{cells.place(0)}: the second column is a voltage or a position, not in {unit}")


def _numbers(cells: Cells, column: int, first: int, unit: str, own: str) -> NDArray[np.float64]:
    """Finite numbers of a column in SI."""
    texts = cells.column(column, first)
    try:
        numbers = column_numbers(texts)
    except CellError as error:
        raise ValueError(f"{cells.place(first + error.row)}: {error.message}") from None
    if not np.isfinite(numbers).all():
        row = int(np.argmin(np.isfinite(numbers)))
        raise ValueError(f"{cells.place(first + row)}: {texts[row].strip()[:40]!r} is not a finite number")
    own = next(
        own for own in ("s", *_UNITS.values()) if parse_unit(own).exponents == parse_unit(unit).exponents
    )
    if parse_unit(unit) != parse_unit(own):
        numbers = np.array([parse_quantity(f"{text} {unit}", own) for text in texts])
    return numbers + 0.0  # no zero is negative
