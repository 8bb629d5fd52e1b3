"""Tables with a row for each value, as loggers of tags write them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array
from hydrofdi.records.columns import Table, channel_named
from hydrofdi.records.description import LongConfig
from hydrofdi.records.text import TextTable

_WINCC = ("VarName", "Time_ms", "Time_ms [µexceldays]")
"""Columns of WinCC: its ``Time_ms`` counts millionths of a day from 1899-12-30."""


class LongTable(Table):
    """The columns of a text whose rows have a name and a value: those of each name, with their own times.

    Titles are the names, then the columns beside name and value, once for each name. A name is that behind
    its last point or slash, if that is one of a channel.
    """

    def __init__(self, text: TextTable, form: LongConfig) -> None:
        self.place, self._text = text.place, text
        self._name, self._value = text.find(form.name), text.find(form.value)
        names = np.array(text.texts(self._name))
        found, counts = np.unique(names, return_counts=True)
        ordered = [str(name) for name in found[np.argsort(-counts, kind="stable")]]
        self._read: dict[int, Array] = {}
        self._times: dict[int, tuple[Array, float]] = {}
        self._rows = [np.flatnonzero(names == name) for name in ordered]
        self._beside = [n for n in range(len(text.titles)) if n not in (self._name, self._value)]
        titles = text.titles
        if _WINCC[0] in titles:
            titles = [_WINCC[2] if title == _WINCC[1] else title for title in titles]
        beside = [titles[n] for n in self._beside]
        later = [f"{title} of {name}" for name in ordered[1:] for title in beside]
        self.titles = [*map(last_part, ordered), *beside, *later]
        self._n_name = len(ordered)
        self.remarks = text.remarks

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return position >= self._n_name and self._text.is_dated(self._origin(position)[0])

    def clocks(self, time: int | None = None) -> dict[int, int]:
        """Position of each name → its column like the column `time` of the most frequent name."""
        if time is None:
            return {}
        offset = time - self._n_name
        return {n: self._n_name + n * len(self._beside) + offset for n in range(self._n_name)}

    def numbers(self, position: int) -> Array:
        """Values of a name, or of a column beside it."""
        origin, rows = self._origin(position)
        if origin not in self._read:
            self._read[origin] = self._text.numbers(origin)
        if self._read[origin].size != sum(map(len, self._rows)):
            raise DataError(f"{self.place}: rows are cut off")
        return self._read[origin][rows]

    def instants(self, position: int) -> tuple[Array, float]:
        """Instants of a name, and the first date of the file."""
        origin, rows = self._origin(position)
        if origin not in self._times:
            self._times[origin] = self._text.instants(origin)
        times, since = self._times[origin]
        return times[rows], since

    def date_by(self, position: int, form: str, date: int | None) -> None:
        """Read dates in a stated format."""
        self._text.date_by(self._origin(position)[0], form, None if date is None else self._origin(date)[0])

    def _origin(self, position: int) -> tuple[int, NDArray[np.intp]]:
        if position < self._n_name:
            return self._value, self._rows[position]
        number, column = divmod(position - self._n_name, len(self._beside))
        return self._beside[column], self._rows[number]


def last_part(name: str) -> str:
    """What stands behind the last point or slash of a name, if that is the name of a channel."""
    last = name.replace("/", ".").rpartition(".")[2].strip("'\" ")
    return last if channel_named(last, "") else name
