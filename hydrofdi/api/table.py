"""Tables of results: named columns with units, one row for each record, window or run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.page import html_table
from hydrofdi.api.places import notebook_library
from hydrofdi.errors import UnknownNameError
from hydrofdi.settings.suggestions import nearest

if TYPE_CHECKING:
    import pandas
    import xarray

_SHOWN = 30
"""Rows that are shown."""

_MOST_TEXT = 40
"""Characters of a text in a row of plain text."""


class Table:
    """Columns of equal length.

    A column may have more dimensions than rows: an output of an indicator with several numbers.

    Attributes
    ----------
    units : dict of str to str
        Column → unit; columns without one are not there.
    remarks : tuple of str
        What has to be known of all rows.
    """

    def __init__(
        self,
        rows: str,
        columns: Mapping[str, Sequence[Any] | NDArray[Any]],
        units: Mapping[str, str],
        dims: Mapping[str, tuple[str, ...]] | None = None,
        remarks: Sequence[str] = (),
        always_shown: Sequence[str] = (),
    ) -> None:
        self._rows = rows
        self._columns = {name: _array(values) for name, values in columns.items()}
        self._dims = dict(dims or {})
        self.units = dict(units)
        self.remarks = tuple(remarks)
        self._always_shown = tuple(always_shown)

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return [*self._columns]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Values of a column, one for each row."""
        if name not in self._columns:
            raise UnknownNameError(f"no column {name!r}{nearest(name, self.columns)}")
        return self._columns[name]

    def __contains__(self, name: str) -> bool:
        return name in self._columns

    def _ipython_key_completions_(self) -> list[str]:
        """Names that a notebook completes in ``table["…``."""
        return self.columns

    def __len__(self) -> int:
        return len(next(iter(self._columns.values()), ()))

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows."""
        for row in range(len(self)):
            yield {
                name: values[row].tolist() if values.ndim > 1 else values[row]
                for name, values in self._items()
            }

    def _items(self) -> Iterator[tuple[str, NDArray[Any]]]:
        yield from self._columns.items()

    def to_dict(self) -> dict[str, list[Any]]:
        """Column → values."""
        return {name: values.tolist() for name, values in self._items()}

    def to_xarray(self) -> xarray.Dataset:
        """A dataset with units as attributes.

        Raises
        ------
        ReportError
            xarray is not installed.
        """
        content = {
            name: ((self._rows, *self._dims.get(name, ())), values, self._attributes(name))
            for name, values in self._items()
        }
        dataset: xarray.Dataset = notebook_library("xarray").Dataset(content)
        return dataset

    def _attributes(self, name: str) -> dict[str, str]:
        return {"units": self.units[name]} if name in self.units else {}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame, a column for each number.

        Raises
        ------
        ReportError
            pandas is not installed.
        """
        frame: pandas.DataFrame = notebook_library("pandas").DataFrame(dict(self._flat()))
        return frame

    def _flat(self) -> Iterator[tuple[str, NDArray[Any]]]:
        for name, values in self._items():
            for index in np.ndindex(values.shape[1:]):
                yield ".".join([name, *map(str, index)]), values[(slice(None), *index)]

    def _shown(self) -> tuple[list[str], list[list[str]], str]:
        """Header and first rows as texts, and a sentence where there are more; empty columns are left out."""
        held = {name: values[:_SHOWN] for name, values in self._items() if values.ndim == 1}
        shown = {
            name: values
            for name, values in held.items()
            if name in self._always_shown or any(map(_text, values))
        }
        header = [f"{name} [{self.units[name]}]" if name in self.units else name for name in shown]
        rows = [[_text(value) for value in row] for row in zip(*shown.values(), strict=True)]
        return header, rows, f"the first {_SHOWN} of {len(self):,} rows" if len(self) > _SHOWN else ""

    def __repr__(self) -> str:
        header, rows, more = self._shown()
        rows = [[_short(text) for text in row] for row in rows]
        widths = [max(map(len, texts)) for texts in zip(header, *rows, strict=True)]
        lines = (
            "  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True))
            for row in (header, *rows)
        )
        return "\n".join([*lines, *([more] if more else []), *self.remarks])

    def _repr_html_(self) -> str:
        header, rows, more = self._shown()
        return html_table(rows, header) + "".join(
            f"<p>{escape(text)}</p>" for text in (more, *self.remarks) if text
        )


def _array(values: Sequence[Any] | NDArray[Any]) -> NDArray[Any]:
    """Numbers as an array of them, NaN where one is missing; everything else as objects."""
    if isinstance(values, np.ndarray) and values.dtype == object:
        return values
    array = np.asarray([np.nan if value is None else value for value in values])
    is_partly_bool = array.dtype.kind != "b" and any(isinstance(value, bool) for value in values)
    if array.dtype.kind in "fiub" and not is_partly_bool:
        return array
    objects = np.empty(len(values), dtype=object)
    objects[:] = list(values)
    return objects


def _short(text: str) -> str:
    return text if len(text) <= _MOST_TEXT else f"{text[: _MOST_TEXT - 1]}…"


def _text(value: Any) -> str:
    if value is None or value != value:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
