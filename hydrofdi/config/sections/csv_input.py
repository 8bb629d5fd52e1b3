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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo

from hydrofdi.settings.messages import counted
from hydrofdi.settings.validation import read_text
from hydrofdi.units import parse_quantity, parse_si, parse_unit

if TYPE_CHECKING:
    from hydrofdi.records.measured.rows import RowReader

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
    # only an experiment with a file loads the reader of measured files
    from hydrofdi.records.measured.columns import split_title
    from hydrofdi.records.measured.description.sections import FormatConfig
    from hydrofdi.records.measured.rows import RowReader, runs

    is_empty = RowReader(FormatConfig(delimiter="space"), []).is_empty
    kept = [(number, line) for number, line in enumerate(text.splitlines(), 1) if not is_empty(line)]
    places, lines = [f"{place}:{number}" for number, _ in kept], [line for _, line in kept]
    first = int(bool(lines) and lines[0].lstrip(" '")[:1].isalpha())
    if not 1 <= len(lines) - first <= MOST_ROWS:
        raise ValueError(f"{place}: contains {counted(len(lines) - first, 'row')}; needs 1 to {MOST_ROWS}")
    reader = RowReader(FormatConfig(), lines[:2])
    reader.titles = reader.header(lines[0]) if first else ["time [s]", "voltage [V]"]
    quantity, units = _header([*map(split_title, reader.titles)], places[0])
    columns: list[list[NDArray[np.float64]]] = []
    for row, found in runs(lines[first:], lambda rows: _columns(reader, rows, units)):
        if isinstance(found, ValueError):
            message = str(found).partition(";")[0]  # the rest tells of descriptions of measured files
            raise ValueError(f"{places[first + row]}: {message}")
        columns.append(found)
    times, values = (
        np.concatenate(parts) + 0.0 for parts in zip(*columns, strict=True)
    )  # no zero is negative
    falling = np.flatnonzero(np.diff(times, prepend=min(times[0], 0.0) - 1.0) <= 0.0)
    if times[0] > 0.0 or falling.size:
        row = 0 if times[0] > 0.0 else int(falling[0])
        message = f"times rise strictly, from zero or less; found {times[row]:g} s"
        raise ValueError(f"{places[first + row]}: {message}")
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


def _header(titles: Sequence[tuple[str, str]], place: str) -> tuple[str, tuple[str, str]]:
    """Quantity of the second column, and the units of both."""
    (_, time), (name, unit), *_ = (*titles, ("", ""), ("", ""))
    time, unit = time or "s", unit or ("m" if name.lower() == "position" else "V")
    try:
        parse_quantity(f"0 {time}", "s")
        exponents = parse_unit(unit).exponents
    except ValueError as error:
        raise ValueError(f"{place}: {error}") from None
    for quantity, own in _UNITS.items():
        if exponents == parse_unit(own).exponents:
            return quantity, (time, unit)
    raise ValueError(f"{place}: the second column is a voltage or a position, not in {unit}")


def _columns(reader: RowReader, rows: Sequence[str], units: Sequence[str]) -> list[NDArray[np.float64]]:
    """Finite numbers of both columns in SI."""
    if (width := reader.width(rows)) != len(units):
        raise ValueError(f"expected two columns, time and voltage; found {width}")
    columns = reader.numbers(rows, range(len(units)))
    if not np.isfinite(columns).all():
        raise ValueError("needs finite numbers")
    for column, unit in enumerate(units):
        if parse_unit(unit).factor != 1:
            texts = reader.texts(rows, [column])[0]
            columns[column] = np.array([parse_si(f"{text} {unit}") for text in texts])
    return columns
