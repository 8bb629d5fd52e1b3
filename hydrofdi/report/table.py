"""The one table: columns with names, units and headings, from which every form follows."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrofdi.errors import ReportError, UnknownNameError
from hydrofdi.report.forms.separated import csv_lines
from hydrofdi.settings.suggestions import nearest

if TYPE_CHECKING:
    import pandas
    import xarray

HOLE = "–"
"""What people read in place of a value that is missing."""

_SHOWN = 30
"""Rows that a notebook shows."""


def plain(value: Any) -> str:
    """A value as people read it: numbers with four digits, a dash if it is missing."""
    if value is None or value != value:
        return HOLE
    return f"{value:.4g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
        Identifier for programs, and the heading if there is no `title`.
    values : sequence
        One for each row; None or NaN if one is missing. With `dims`, an array of shape (n_row, …), which only
        programs see.
    unit : str
        Unit of the values.
    title : str
        Heading for people, with a unit in brackets if the texts have another one.
    text : callable
        Value → what people read.
    is_text : bool
        Whether it contains words: left-aligned, and folded if it is too wide.
    strong : collection of int
        Rows whose value stands out.
    dims : tuple of str
        Names of the further dimensions of `values`.
    """

    name: str
    values: Sequence[Any]
    unit: str = ""
    title: str = ""
    text: Callable[[Any], str] = plain
    is_text: bool = False
    strong: Sequence[int] = ()
    dims: tuple[str, ...] = ()

    @property
    def heading(self) -> str:
        """The title, or name and unit."""
        return self.title or (f"{self.name} [{self.unit}]" if self.unit not in ("", "1") else self.name)

    @property
    def listed(self) -> list[Any]:
        """The values as Python's own types; None if a number is missing."""
        values = self.values.tolist() if isinstance(self.values, np.ndarray) else self.values
        return [None if isinstance(each, float) and not math.isfinite(each) else each for each in values]


@dataclass(frozen=True, repr=False)
class Table:
    """Columns of equal length.

    Attributes
    ----------
    columns : tuple of Column
    title : str
    key : str
        Identity within a report.
    notes : tuple of str
        Legend, and what has to be known of all rows.
    breaks : collection of int
        Rows before which a new group begins.
    n_lead : int
        First columns, which say what a row is.
    row : str
        What a row is, such as ``record``: the dimension of a data set.
    is_folded : bool
        Whether a page shows it only on request.
    """

    columns: tuple[Column, ...]
    title: str = ""
    key: str = ""
    notes: tuple[str, ...] = ()
    breaks: Sequence[int] = ()
    n_lead: int = 1
    row: str = "row"
    is_folded: bool = False

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0

    def __getitem__(self, name: str) -> Sequence[Any]:
        """Values of a column.

        Raises
        ------
        UnknownNameError
            There is no such column.
        """
        if name not in self:
            names = [column.name for column in self.columns]
            raise UnknownNameError(f"no column {name!r}{nearest(name, names)}")
        return next(column.values for column in self.columns if column.name == name)

    def __contains__(self, name: str) -> bool:
        return any(column.name == name for column in self.columns)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows, for programs."""
        columns = self.to_dict()
        return (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))

    @property
    def units(self) -> dict[str, str]:
        """Column → unit; columns without one are not there."""
        return {column.name: column.unit for column in self.columns if column.unit}

    @property
    def shown(self) -> tuple[Column, ...]:
        """The columns that people read."""
        return tuple(column for column in self.columns if not column.dims)

    def texts(self, n_row: int | None = None) -> Iterator[list[tuple[str, bool]]]:
        """The rows as people read them: texts, and whether each stands out."""
        shown = self.shown
        for row in range(len(self))[:n_row]:
            yield [(column.text(column.values[row]), row in column.strong) for column in shown]

    def to_dict(self) -> dict[str, list[Any]]:
        """Column → values; None if a number is missing."""
        return {column.name: column.listed for column in self.columns}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame, a column for each number.

        Raises
        ------
        ReportError
            pandas is not installed.
        """
        flat: dict[str, Any] = {}
        for column in self.columns:
            values = np.asarray(column.values) if column.dims else column.values
            for index in np.ndindex(np.shape(values)[1:]) if column.dims else ():
                flat[".".join([column.name, *map(str, index)])] = np.asarray(values)[(slice(None), *index)]
            if not column.dims:
                flat[column.name] = values
        frame: pandas.DataFrame = library("pandas").DataFrame(flat)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """A data set with units as attributes.

        Raises
        ------
        ReportError
            xarray is not installed.
        """
        units = {name: {"units": unit} for name, unit in self.units.items()}
        dataset: xarray.Dataset = library("xarray").Dataset({
            column.name: ((self.row, *column.dims), np.asarray(column.values), units.get(column.name, {}))
            for column in self.columns
        })  # fmt: skip
        return dataset

    def to_csv(self) -> str:
        """A line for each row; numbers in their shortest exact form, an empty field if one is missing."""
        columns = self.to_dict()
        return "".join(csv_lines([columns, *zip(*columns.values(), strict=True)]))

    def to_parquet(self) -> bytes:
        """The same as Parquet.

        Raises
        ------
        ReportError
            pyarrow is not installed.
        """
        sink = io.BytesIO()
        library("pyarrow.parquet").write_table(library("pyarrow").table(self.to_dict()), sink)
        return sink.getvalue()

    def to_markdown(self) -> str:
        """A pipe table."""
        heads, sides = [escaped(column.heading) for column in self.shown], ["---:", "---"]
        lines = [heads, [sides[column.is_text] for column in self.shown]]
        for row in self.texts():
            lines.append([f"**{escaped(text)}**" if is_strong else escaped(text) for text, is_strong in row])
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def to_html(self, n_row: int | None = None) -> str:
        """A ``table`` element with its caption and notes."""
        classes = [' class="words"' if column.is_text else "" for column in self.shown]
        heads = (f'<th scope="col"{of}>' for of in classes)
        lines = [f"{tag}{escape(each.heading)}</th>" for tag, each in zip(heads, self.shown, strict=True)]
        parts = [f"<caption>{escape(self.title)}</caption>"] if self.title else []
        parts.append(f"<thead><tr>{''.join(lines)}</tr></thead>\n<tbody>")
        for position, row in enumerate(self.texts(n_row)):
            parts.append('<tr class="break">' if position in self.breaks else "<tr>")
            for of, (text, is_strong) in zip(classes, row, strict=True):
                shown = f"<strong>{escape(text)}</strong>" if is_strong else escape(text)
                parts.append(f"<td{of}>{shown}</td>")
            parts.append("</tr>\n")
        notes = "".join(f'\n<p class="note">{escape(note)}</p>' for note in self.notes)
        return f'<table id="{self.key}">{"".join(parts)}</tbody></table>{notes}'

    def _repr_html_(self) -> str:
        return f"{self.to_html(_SHOWN)}<p>{self._more()}</p>"

    def __repr__(self) -> str:
        lines = [[column.heading for column in self.shown]]
        lines += [[text for text, _ in row] for row in self.texts(_SHOWN)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        rows = ("  ".join(map(str.rjust, line, widths)) for line in lines)
        return "\n".join([*rows, *([self._more()] if self._more() else []), *self.notes])

    def _more(self) -> str:
        return f"the first {_SHOWN} of {len(self):,} rows" if len(self) > _SHOWN else ""


def library(name: str) -> Any:
    """A library of an extra.

    Raises
    ------
    ReportError
        It is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        extra = "parquet" if name.startswith("pyarrow") else "notebook"
        raise ReportError(f"{name} is not installed: pip install 'hydrofdi[{extra}]'") from None


def escaped(text: str) -> str:
    """A text for Markdown."""
    return text.replace("|", r"\|").replace("*", r"\*")
