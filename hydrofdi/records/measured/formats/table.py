"""What every format gives: named columns, read one by one."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array, Remark
from hydrofdi.settings.mistakes import nearest

_TITLE = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*")
_MOST_SHOWN = 12


def split_title(title: str) -> tuple[str, str]:
    """Name and unit of a header such as ``P1 [bar]``; no unit where it has none."""
    match = _TITLE.fullmatch(title)
    if match is None or not match[1] or (match[2] or match[3] or "").isdigit():
        return title.strip(), ""
    return match[1], (match[2] or match[3] or "").strip()


class Table(ABC):
    """Columns of one file.

    Attributes
    ----------
    place : str
        The file, for messages.
    titles : sequence of str
        Header of each column, or its number.
    remarks : tuple of Remark
        What was found in reading.
    """

    place: str
    titles: Sequence[str]
    remarks: tuple[Remark, ...] = ()

    def find(self, column: str) -> int:
        """Position of a column.

        Raises
        ------
        DataError
            There is no such column, or more than one.
        """
        for titles in (self.titles, [split_title(title)[0] for title in self.titles]):
            found = [position for position, title in enumerate(titles) if title == column]
            if len(found) > 1:
                numbers = " and ".join(str(position + 1) for position in found)
                raise DataError(f"{self.place}: column {column!r} occurs as {numbers}; give its number")
            if found:
                return found[0]
        if column.isdecimal() and 1 <= int(column) <= len(self.titles):
            return int(column) - 1
        raise DataError(f"{self.place}: has no column {column!r}{self._hint(column)}")

    def unit(self, position: int) -> str:
        """Unit that the file states for a column; empty where it states none."""
        return split_title(self.titles[position])[1]

    @abstractmethod
    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,); NaN where missing.

        Raises
        ------
        DataError
            It holds something else than real numbers.
        """

    @abstractmethod
    def text(self, position: int) -> str:
        """The one value of a column that does not change.

        Raises
        ------
        DataError
            It changes.
        """

    def _hint(self, column: str) -> str:
        if hint := nearest(column, [*self.titles, *(split_title(title)[0] for title in self.titles)]):
            return hint
        more = ", …" if len(self.titles) > _MOST_SHOWN else ""
        return f"; it has {', '.join(self.titles[:_MOST_SHOWN])}{more}" if self.titles else "; it has none"
