"""The table that every format returns: named columns, read one by one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.measured.columns import find_column, split_title

MOST_BYTES = 2**31


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

    @property
    def has_numbers(self) -> bool:
        """Whether there are numbers or dates below the titles."""
        return True

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

    def load(self, positions: Sequence[int]) -> None:  # noqa: B027
        """Prepare to return columns, if reading them together is faster."""

    @abstractmethod
    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,); NaN where missing.

        Raises
        ------
        DataError
            It contains something other than real numbers.
        """

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return False

    def instants(self, position: int) -> Array:
        """Values of a time column, shape (n_row,); of dates, the time since the first one [s].

        Raises
        ------
        DataError
            It contains dates and something else.
        """
        return self.numbers(position)

    def text(self, position: int) -> str:
        """The value of a constant column.

        Raises
        ------
        DataError
            The column changes, or contains no text.
        """
        raise DataError(f"{self.place}: column {self.titles[position]!r} is not text")


class RejectionError(Exception):
    """No record can be formed; it is listed with the reason, and the other records continue.

    Attributes
    ----------
    remark : Issue
    """

    def __init__(self, kind: str, text: str) -> None:
        self.remark = Issue(text, kind=kind, is_unusable=True)
        super().__init__(text)


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Turn whatever a library raises on a broken file into `RejectionError`."""
    try:
        yield
    except (DataError, RejectionError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise RejectionError("damaged", f"cannot be read as {what}: {reason}") from None
