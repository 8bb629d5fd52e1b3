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
import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.settings.counting import counted
from hydrofdi.units import Unit, parse_unit

MOST_ROWS = 100_000
"""Rows that a file may have."""

_MOST_BYTES = 100 * MOST_ROWS
_SHOWN_MISTAKES = 5
_UNITS = {"voltage": "V", "position": "m"}
_TITLE = re.compile(r"\s*([^\[\]()]*?)\s*(?:\[([^\[\]]*)\])?\s*")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")
_DIGITS = re.compile(r"\s*[-+]?\d+\s*")
_POINT = "decimals take a point, not a comma"
_ONE = Fraction(1)


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


class CsvError(ValueError):
    """A CSV text that is not an input, with its mistakes as pairs of line (0: the whole file) and text."""

    def __init__(self, mistakes: list[tuple[int, str]]) -> None:
        self.mistakes = mistakes
        line, message = mistakes[0]
        super().__init__(f"line {line}: {message}" if line else message)


def read_csv_input(path: Path) -> str:
    """The contents of a CSV file as a configuration holds them.

    Raises
    ------
    CsvError
        The file cannot be read, or is not an input.
    """
    return held_text(path.name, _file_text(path))


def held_text(name: str, text: str) -> str:
    """A CSV text in the form that a configuration holds, with a name for people.

    Raises
    ------
    CsvError
        The text is not an input.
    """
    rows = parse_rows(text)
    pairs = zip(rows.times.tolist(), rows.values.tolist(), strict=True)
    lines = [f"# {' '.join(name.split())}", f"time [s],{rows.quantity} [{_UNITS[rows.quantity]}]"]
    lines += [f"{time!r},{value!r}" for time, value in pairs]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=64)
def require_held_text(text: str) -> str:
    """The text itself, if it is one that a configuration may hold.

    Raises
    ------
    ValueError
        The text is not in this form.
    """
    if "\n" not in text:
        readers = "an experiment file or settings"
        raise ValueError(f"{text!r} is a path; a file is only read if {readers} names it")
    name = text.partition("\n")[0].removeprefix("#") if text.startswith("#") else "text"
    return held_text(name, text)


@lru_cache(maxsize=64)
def parse_rows(text: str) -> HeldRows:
    """The rows of a CSV text.

    Raises
    ------
    CsvError
        The text is not an input.
    """
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()[:1] not in ("", "#")]
    if not lines:
        raise CsvError([(0, "contains no rows of time and voltage")])
    separator = next((mark for mark in ";\t" if mark in lines[0][1]), ",")
    cells = [(n, [_unquoted(cell) for cell in line.split(separator)]) for n, line in lines]
    quantity, units = "voltage", (parse_unit("s"), parse_unit("V"))
    if not _is_number(first := cells[0][1][0]) and not _DECIMAL_COMMA.fullmatch(first):
        quantity, units = _header(*cells.pop(0))
    if not 1 <= len(cells) <= MOST_ROWS:
        raise CsvError([(0, f"contains {counted(len(cells), 'row')}; needs 1 to {MOST_ROWS}")])
    table, mistakes = _numbers(cells, units)
    mistakes += [] if mistakes else _order_mistakes(cells, table[:, 0])
    if mistakes:
        raise CsvError(_first(mistakes))
    return HeldRows(quantity, np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1]))


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


def _file_text(path: Path) -> str:
    try:
        if not path.is_file():
            what = "is a folder" if path.is_dir() else "is not a file" if path.exists() else "no such file"
            raise CsvError([(0, what)])
        if path.stat().st_size > _MOST_BYTES:
            raise CsvError([(0, f"is larger than the {_MOST_BYTES / 1e6:g} MB that an input may have")])
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise CsvError([(0, "is not a text file in UTF-8")]) from None
    except (OSError, ValueError) as error:
        if isinstance(error, CsvError):
            raise
        raise CsvError([(0, getattr(error, "strerror", None) or str(error))]) from None
    if "\0" in text:
        raise CsvError([(0, "is not a text file in UTF-8")])
    return text


def _header(line: int, titles: list[str]) -> tuple[str, tuple[Unit, Unit]]:
    """Quantity of the second column, and the units of both."""
    _require_two(line, titles)
    parsed = [_TITLE.fullmatch(title) for title in titles]
    if parsed[0] is None or parsed[1] is None:
        raise CsvError([(line, "a header is like 'time [s], voltage [V]', units in square brackets")])
    try:
        time = parse_unit(parsed[0][2] or "s")
        named = "m" if parsed[1][1].lower() == "position" else "V"
        value = parse_unit(parsed[1][2] or named)
    except ValueError as error:
        raise CsvError([(line, str(error))]) from None
    if time.exponents != parse_unit("s").exponents:
        raise CsvError([(line, f"the first column is a time; found the unit {parsed[0][2]!r}")])
    for quantity, unit in _UNITS.items():
        if value.exponents == parse_unit(unit).exponents:
            return quantity, (time, value)
    message = f"the second column is a voltage (or a position); found the unit {parsed[1][2]!r}"
    raise CsvError([(line, message)])


def _unquoted(cell: str) -> str:
    inner = cell.strip()
    return inner[1:-1] if len(inner) > 1 and inner[0] == inner[-1] and inner[0] in "\"'" else cell


def _require_two(line: int, cells: list[str]) -> None:
    if len(cells) != 2:
        raise CsvError([(line, _columns_message(cells))])


def _columns_message(cells: list[str]) -> str:
    hint = f"; {_POINT}" if len(cells) in (3, 4) and all(map(_DIGITS.fullmatch, cells)) else ""
    return f"expected two columns, time and voltage; found {len(cells)}{hint}"


def _numbers(
    cells: list[tuple[int, list[str]]], units: tuple[Unit, Unit]
) -> tuple[NDArray[np.float64], list[tuple[int, str]]]:
    table, mistakes = np.full((len(cells), 2), np.nan), []
    for row, (line, texts) in enumerate(cells):
        if len(texts) != 2:
            mistakes.append((line, _columns_message(texts)))
            continue
        for column, text in enumerate(texts):
            try:
                table[row, column] = _number(text, units[column].factor)
            except ValueError as error:
                mistakes.append((line, str(error)))
    return table, mistakes


def _number(text: str, factor: Fraction) -> float:
    """A finite number in SI."""
    if not _is_number(text):
        hint = f"; {_POINT}" if _DECIMAL_COMMA.fullmatch(text) else ""
        raise ValueError(f"{text.strip()[:40]!r} is not a number{hint}")
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text.strip()[:40]!r} is not a finite number")
    if value == 0.0:
        return 0.0
    return value if factor == _ONE else float(Fraction(text.strip()) * factor)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text


def _order_mistakes(cells: list[tuple[int, list[str]]], times: NDArray[np.float64]) -> list[tuple[int, str]]:
    mistakes = []
    if times[0] > 0.0:
        mistakes.append((cells[0][0], f"the first time must be zero or less; found {times[0]:g} s"))
    for row in (np.flatnonzero(np.diff(times) <= 0.0) + 1).tolist():
        message = f"time {times[row]:g} s does not come after {times[row - 1]:g} s of the row before"
        mistakes.append((cells[row][0], message))
    return mistakes


def _first(mistakes: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """The mistakes that are worth telling."""
    more = len(mistakes) - _SHOWN_MISTAKES
    shown = mistakes[:_SHOWN_MISTAKES]
    return [*shown, (0, f"and {more} more mistakes like these")] if more > 0 else shown
