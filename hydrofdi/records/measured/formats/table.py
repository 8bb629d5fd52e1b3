"""The table that every format returns: named columns, read one by one."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Array

_TITLE = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*")
_MOST_SHOWN = 12
_LONGEST_TITLE = 1000
"""Most characters of a header that is split into name and unit."""


def split_title(title: str) -> tuple[str, str]:
    """Name and unit of a header such as ``P1 [bar]``; an empty unit if it has none."""
    match = _TITLE.fullmatch(title) if len(title) <= _LONGEST_TITLE else None
    if match is None or not match[1] or (match[2] or match[3] or "").isdigit():
        return title.strip(), ""
    return match[1], (match[2] or match[3] or "").strip()


def shortened(title: str, most: int = 60) -> str:
    """A header as a message quotes it."""
    return title if len(title) <= most else f"{title[: most - 1]}…"


def find_column(titles: Sequence[str], column: str, place: str) -> int:
    """Position of a column by its title, its name without the unit, or its number.

    Raises
    ------
    DataError
        There is no such column, or more than one.
    """
    names = [split_title(title)[0] for title in titles]
    for known in (titles, names):
        found = [position for position, title in enumerate(known) if title == column]
        if len(found) > 1:
            numbers = " and ".join(str(position + 1) for position in found)
            raise DataError(f"{place}: column {column!r} occurs as {numbers}; give its number")
        if found:
            return found[0]
    if column.isdecimal() and 1 <= int(column) <= len(titles):
        return int(column) - 1
    more = ", …" if len(titles) > _MOST_SHOWN else ""
    shown = [shortened(title) for title in titles[:_MOST_SHOWN]]
    raise DataError(f"{place}: has no column {column!r}; it has {', '.join(shown) or 'none'}{more}")


class Table(ABC):
    """Columns of one file.

    Attributes
    ----------
    place : str
        The file, for messages.
    titles : sequence of str
        Header of each column, or its number.
    remarks : tuple of Issue
        Findings while reading.
    """

    place: str
    titles: Sequence[str]
    remarks: tuple[Issue, ...] = ()

    @property
    def has_decimal_commas(self) -> bool:
        """Whether numbers seem to have decimal commas, contrary to the description."""
        return False

    def find(self, column: str) -> int:
        """Position of a column.

        Raises
        ------
        DataError
            There is no such column, or more than one.
        """
        return find_column(self.titles, column, self.place)

    def unit(self, position: int) -> str:
        """Unit that the file states for a column; empty if it states none."""
        return split_title(self.titles[position])[1]

    @abstractmethod
    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,); NaN where missing.

        Raises
        ------
        DataError
            It contains something other than real numbers.
        """

    def dates(self, position: int) -> Array | None:
        """Time since the first date of a column [s], shape (n_row,); None if it contains no dates.

        Raises
        ------
        DataError
            It contains dates and something else.
        """
        return None

    def instants(self, position: int) -> Array:
        """Values of a time column, shape (n_row,)."""
        return self.numbers(position)

    @abstractmethod
    def text(self, position: int) -> str:
        """The value of a constant column.

        Raises
        ------
        DataError
            The column changes.
        """
