"""The one table, from which every form follows."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from html import escape
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import ReportError, UnknownNameError
from hydrofdi.settings.messages import convert, nearest, number_text, readable_unit, typeset

if TYPE_CHECKING:
    import pandas
    import xarray


_SHOWN = 30
"""Rows that a notebook shows."""

TEXT_WIDTH = 100
"""Columns of text where nothing says how many there are."""

_GAP, _HEADING, _SENTENCE = 2, 10, 24
"""Blanks between columns, and widths: of a line of a heading, and of folded words."""

_SEAM, _BLANK = "\ue000", "\ue001"
"""Marks of a place in a word at which it may be broken, and of a blank at which a line is not."""

_CONTROLS = dict.fromkeys([*range(0x20), *range(0x7F, 0xA0)], "�")
"""Characters of texts from outside that would act on the terminal."""


_UNITS = {
    "L_per_min": "L/min",
    "percentage_points": "points",
    "percent": "%",
    "MPa": "MPa",
    "h": "h",
    "s": "s",
}
"""End of a key of JSON → unit."""


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
        Identifier for programs, and the heading if there is no `title`.
    values : sequence or ndarray
        One for each row; None or NaN if one is missing. With `dims`, an array of shape (n_row, …), which only
        programs see.
    unit : str
        Unit of the values.
    title : str
        Heading for people, with a unit in brackets if the texts have another one.
    text : callable or sequence of str
        Value → what people read; or the texts of all rows.
    is_text : bool
        Whether it contains words: left-aligned, and folded if it is too wide.
    strong : collection of int
        Rows whose value stands out.
    dims : tuple of str
        Names of the further dimensions of `values`.
    is_shown : bool
        Whether people see it, and not only programs.
    """

    name: str
    values: Sequence[Any] | NDArray[Any]
    unit: str = ""
    title: str = ""
    text: Callable[[Any], str] | Sequence[str] = number_text
    is_text: bool = False
    strong: Sequence[int] = ()
    dims: tuple[str, ...] = ()
    is_shown: bool = True

    @property
    def heading(self) -> str:
        """The title, or name and unit."""
        unit = "" if self.unit in ("", "1") else f" [{typeset(self.unit)}]"
        return self.title or f"{self.name}{unit}"

    @property
    def listed(self) -> list[Any]:
        """The values as Python's own types; None if a number is missing."""
        is_array = isinstance(self.values, np.ndarray)
        listed: list[Any] = plain(self.values if is_array else [*self.values])
        return listed

    @property
    def array(self) -> NDArray[Any]:
        """The values as an array: NaN if a number is missing, objects unless all are numbers or Booleans."""
        if isinstance(self.values, np.ndarray):
            return self.values
        array = np.array([math.nan if each is None else each for each in self.values])
        has_bool = any(isinstance(each, bool) for each in self.values)
        if array.dtype.kind in "fiub" and (array.dtype.kind == "b") == has_bool:
            return array
        array = np.empty(len(self.values), dtype=object)
        array[:] = list(self.values)
        return array

    def text_of(self, row: int) -> str:
        """What people read in a row."""
        return self.text(self.values[row]) if callable(self.text) else self.text[row]

    @property
    def flat(self) -> Iterator[Column]:
        """A column for each number of a row: itself, or ``name.0``, ``name.1`` … with further dimensions."""
        if not self.dims:
            yield self
            return
        array = np.asarray(self.values)
        for index in np.ndindex(array.shape[1:]):
            name = ".".join([self.name, *map(str, index)])
            yield replace(self, name=name, values=array[(slice(None), *index)], dims=())


def quantity(
    name: str,
    values: Iterable[Any],
    unit: str,
    title: str = "",
    *,
    sizes: Sequence[float | None] = (),
    is_shown: bool = True,
) -> Column:
    """A column of numbers in SI; people read them in a unit that suits the largest, or that of `sizes`."""
    array = _numbers(values)
    found = np.abs(_numbers(sizes) if sizes else array)
    shown = readable_unit(unit, float(np.max(found, where=np.isfinite(found), initial=0.0)))
    text = partial(number_text, scale=convert(1.0, shown, unit))
    suffix = "" if shown in ("", "1") else f" [{typeset(shown)}]"
    return Column(name, array, unit, (title or name) + suffix, text, is_shown=is_shown)


def _numbers(values: Iterable[Any]) -> NDArray[np.float64]:
    return np.array([math.nan if each is None else each for each in values], dtype=float)


@dataclass(frozen=True, repr=False)
class Table:
    """Columns of equal length.

    Attributes
    ----------
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
    most : int, optional
        Rows that a text shows.
    """

    content: tuple[Column, ...]
    title: str = ""
    key: str = ""
    notes: tuple[str, ...] = ()
    breaks: Sequence[int] = ()
    n_lead: int = 1
    row: str = "row"
    most: int | None = None

    def __len__(self) -> int:
        return len(self.content[0].values) if self.content else 0

    @classmethod
    def of(cls, columns: Mapping[str, Sequence[Any] | NDArray[Any]], **more: Any) -> Table:
        """Columns by their names; those that contain texts are of words."""
        are_words = {name: any(isinstance(each, str) for each in own) for name, own in columns.items()}
        return cls(tuple(Column(name, own, is_text=are_words[name]) for name, own in columns.items()), **more)

    @classmethod
    def of_records(
        cls, records: Sequence[Mapping[str, Any]], leave_out: Sequence[str] = (), **more: Any
    ) -> Table:
        """A row for each record of JSON, a column for each key of any."""
        keys = [*dict.fromkeys(key for each in records for key in each if key not in leave_out)]
        made = cls.of({key: [each.get(key) for each in records] for key in keys}, **more)
        named = (replace(each, title=_heading(each.name), text=_told) for each in made.content)
        return replace(made, content=tuple(named))

    def at(self, rows: Sequence[int]) -> Table:
        """Some of the rows."""
        content = (
            replace(
                each,
                values=[each.values[row] for row in rows],
                text=each.text if callable(each.text) else [each.text[row] for row in rows],
                strong=(),
            )
            for each in self.content
        )
        return replace(self, content=tuple(content), breaks=())

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return [column.name for column in self.content]

    @property
    def remarks(self) -> tuple[str, ...]:
        """The notes."""
        return self.notes

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Values of a column."""
        if name not in self:
            raise UnknownNameError(f"no column {name!r}{nearest(name, self.columns)}")
        return next(column.array for column in self.content if column.name == name)

    def _ipython_key_completions_(self) -> list[str]:
        return self.columns

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """The rows, for programs."""
        columns = self.to_dict()
        return (dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))

    @property
    def units(self) -> dict[str, str]:
        """Column → unit; columns without one are not there."""
        return {column.name: column.unit for column in self.content if column.unit not in ("", "1")}

    @property
    def shown(self) -> tuple[Column, ...]:
        """The columns that people read; those of words only if they have any."""
        readable = (each for each in self.content if each.is_shown and not each.dims)
        return tuple(
            each for each in readable if not each.is_text or any(map(each.text_of, range(len(self))))
        )

    @property
    def n_shown_lead(self) -> int:
        """How many of them say what a row is."""
        names = self.columns[: self.n_lead]
        return sum(each.name in names for each in self.shown)

    def texts(self) -> Iterator[list[tuple[str, bool]]]:
        """The rows as people read them, at most `most`: texts, and whether each stands out."""
        shown = self.shown
        for row in range(len(self))[: self.most]:
            yield [(column.text_of(row), row in column.strong) for column in shown]

    def to_dict(self) -> dict[str, list[Any]]:
        """Column → values; None if a number is missing."""
        return {column.name: column.listed for column in self.content}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame, a column for each number.

        Raises
        ------
        ReportError
            pandas is not installed.
        """
        flat = {each.name: each.array for column in self.content for each in column.flat}
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
            column.name: ((self.row, *column.dims), column.array, units.get(column.name, {}))
            for column in self.content
        })  # fmt: skip
        return dataset

    def to_csv(self, *, header: bool = True) -> str:
        """A line for each row; numbers in their shortest exact form, an empty field if one is missing."""
        columns = self.flat()
        return "".join(csv_lines([*([columns] if header else []), *zip(*columns.values(), strict=True)]))

    def flat(self) -> dict[str, list[Any]]:
        """Name → numbers, a column for each number of a row."""
        return {each.name: each.listed for column in self.content for each in column.flat}

    def to_parquet(self) -> bytes:
        """The same as Parquet.

        Raises
        ------
        ReportError
            pyarrow is not installed.
        """
        sink = io.BytesIO()
        library("pyarrow.parquet").write_table(library("pyarrow").table(self.flat()), sink)
        return sink.getvalue()

    def to_markdown(self) -> str:
        """A pipe table."""
        heads, sides = [escaped(column.heading) for column in self.shown], ["---:", "---"]
        lines = [heads, [sides[column.is_text] for column in self.shown]]
        for row in self.texts():
            lines.append([f"**{escaped(text)}**" if is_strong else escaped(text) for text, is_strong in row])
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def to_latex(self) -> str:
        """A ``tabular`` for LaTeX with the package booktabs."""
        sides = "".join("rl"[column.is_text] for column in self.shown)
        lines = [rf"\begin{{tabular}}{{{sides}}}", r"\toprule"]
        lines += [" & ".join(latex(column.heading) for column in self.shown) + r" \\", r"\midrule"]
        for position, row in enumerate(self.texts()):
            cells = (rf"\textbf{{{latex(text)}}}" if strong else latex(text) for text, strong in row)
            lines += [r"\addlinespace"] * (position in self.breaks) + [" & ".join(cells) + r" \\"]
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"])

    def to_html(self) -> str:
        """A ``table`` element with its caption and notes."""
        classes = [' class="words"' if column.is_text else "" for column in self.shown]
        heads = (
            f'<th scope="col"{of}>{escape(each.heading)}</th>'
            for of, each in zip(classes, self.shown, strict=True)
        )
        parts = [f"<caption>{escape(self.title)}</caption>"] if self.title else []
        parts.append(f"<thead><tr>{''.join(heads)}</tr></thead>\n<tbody>")
        for position, row in enumerate(self.texts()):
            parts.append('<tr class="break">' if position in self.breaks else "<tr>")
            for of, (text, is_strong) in zip(classes, row, strict=True):
                shown = f"<strong>{escape(text)}</strong>" if is_strong else escape(text)
                parts.append(f"<td{of}>{shown}</td>")
            parts.append("</tr>\n")
        notes = "".join(f'\n<p class="note">{escape(note)}</p>' for note in self.notes)
        key = f' id="{self.key}"' if self.key else ""
        return f"<table{key}>{''.join(parts)}</tbody></table>{notes}"

    def _repr_html_(self) -> str:
        first = replace(self, most=self.most or _SHOWN)
        more = "".join(f"<p>{more}</p>" for more in first._more)
        return first.to_html().replace(' class="words"', ' style="text-align: left"') + more

    def __repr__(self) -> str:
        title = [self.title] if self.title else []
        return "\n".join([*title, *replace(self, most=self.most or _SHOWN).lines(), *self.notes])

    @property
    def _more(self) -> list[str]:
        is_cut = self.most is not None and self.most < len(self)
        return [f"… the first {self.most} of {len(self):,} rows"] if is_cut else []

    def lines(self, width: int = TEXT_WIDTH) -> Iterator[str]:
        """Lines of text: numbers are never cut; columns that do not fit in a width continue below.

        Each part begins with the columns that say what a row is. Wide words are folded.
        """
        rows = [[*map(_cell, self.shown, row)] for row in self.texts()]
        heads = [*map(_heading_lines, self.shown)]
        lead = [*range(self.n_shown_lead)]
        part = [*lead]
        for index in range(len(lead), len(heads)):
            needed = sum(_room(self.shown[at], heads[at], [row[at] for row in rows]) for at in [*part, index])
            if len(part) > len(lead) and needed + _GAP * len(part) > width:
                yield from self._grid(part, heads, rows, width)
                part = [*lead]
            part.append(index)
        yield from self._grid(part, heads, rows, width)
        yield from self._more

    def _grid(
        self, part: list[int], heads: list[list[str]], rows: list[list[str]], width: int
    ) -> Iterator[str]:
        """Some columns beside each other, the widest words folded as far as it takes."""
        are_words = [self.shown[at].is_text for at in part]
        texts = [[*heads[at], *(row[at] for row in rows)] for at in part]
        widths = [max(map(len, own)) for own in texts]
        least = [
            max(len(piece) for text in own for piece in folded(text, 1, cuts=False)) if is_words else size
            for own, is_words, size in zip(texts, are_words, widths, strict=True)
        ]
        while sum(widths) + _GAP * (len(part) - 1) > width:
            can = [at for at, size in enumerate(widths) if size > least[at]]
            if not can:
                break
            widths[max(can, key=widths.__getitem__)] -= 1
        deepest = max((len(heads[at]) for at in part), default=0)
        lowered = [[""] * (deepest - len(lines)) + lines for lines in heads]
        for number, row in enumerate([lowered, *([[text] for text in row] for row in rows)], -1):
            if number in self.breaks:
                yield ""
            cells = [
                [line for text in row[at] for line in folded(text, size)] if is_words else row[at]
                for at, size, is_words in zip(part, widths, are_words, strict=True)
            ]
            sides = [str.ljust if is_words else str.rjust for is_words in are_words]
            for line in zip_longest(*cells, fillvalue=""):
                sized = (side(text, size) for side, text, size in zip(sides, line, widths, strict=True))
                yield (" " * _GAP).join(sized).rstrip()


def _cell(column: Column, cell: tuple[str, bool]) -> str:
    """A text without what would act on a terminal, and with a mark if it stands out."""
    text, is_strong = cell
    return text.translate(_CONTROLS) + ("*" if is_strong else _unmarked(column))


def _unmarked(column: Column) -> str:
    """What stands in place of a mark."""
    return " " if len(column.strong) and not column.is_text else ""


def _heading_lines(column: Column) -> list[str]:
    """A heading in lines, broken at blanks, dots and underscores; its unit in the last."""
    name, bracket, unit = column.heading.partition(" [")
    lines = folded(name, _SENTENCE if column.is_text else _HEADING, cuts=False)
    return [f"{line}{_unmarked(column)}" for line in (*lines, *([f"[{unit}"] if bracket else []))]


def _room(column: Column, heading: list[str], cells: list[str]) -> int:
    """Room that a column needs."""
    width = max(map(len, [*heading, *cells]))
    return min(width, _SENTENCE) if column.is_text else width


def folded(text: str, width: int, *, cuts: bool = True) -> list[str]:
    """A text in lines of at most `width`, broken at blanks, and long names after dots and underscores.

    A part of a name that is longer than a line is cut, or not. A mark of one character stays with the word
    before it.
    """
    kept = re.sub(r"\s+(?=\S(?:\s|$))", _BLANK, text.strip())
    parted = re.sub(
        rf"\S{{{width + 1},}}", lambda word: re.sub(r"(?<=[._])(?=[^\W\d_])", f"{_SEAM} ", word[0]), kept
    )
    lines = wrap(parted, width, break_long_words=cuts, break_on_hyphens=False)
    return [re.sub(f"{_SEAM} ?", "", line).replace(_BLANK, " ") for line in lines] or [""]


def _heading(key: str) -> str:
    """What people read for a key of JSON, such as ``Delay median [s]`` for ``delay_median_s``."""
    ends = ((key.removesuffix(f"_{end}"), f" [{unit}]") for end, unit in _UNITS.items())
    name, unit = next(((name, unit) for name, unit in ends if name != key), (key, ""))
    words = name.replace("_", " ")
    return (words[0].upper() if words[0].isascii() else words[0]) + words[1:] + unit


def _told(value: Any) -> str:
    return ("no", "yes")[value] if isinstance(value, bool) else number_text(value)


def library(name: str) -> Any:
    """A library of an extra."""
    try:
        return import_module(name)
    except ImportError:
        extra = "parquet" if name.startswith("pyarrow") else "notebook"
        raise ReportError(f"{name} is not installed: pip install 'hydrofdi[{extra}]'") from None


def escaped(text: str) -> str:
    """A text for Markdown."""
    return text.replace("|", r"\|").replace("*", r"\*")


_LATEX = str.maketrans({
    **{each: rf"\{each}" for each in "&%$#_{}"},
    "\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}", "–": "--", "…": r"\dots{}",
    "\N{NO-BREAK SPACE}": "~", "−": "$-$", "²": "$^2$", "³": "$^3$", "′": "$'$", "√": r"$\surd$",
    "δ": r"$\delta$", "β": r"$\beta$", "ζ": r"$\zeta$", "ρ": r"$\rho$", "σ": r"$\sigma$", "µ": r"$\mu$",
    "·": r"$\cdot$", "×": r"$\times$",
    "<": "$<$", ">": "$>$", "≤": r"$\leq$", "≥": r"$\geq$", "→": r"$\to$", "±": r"$\pm$",
})  # fmt: skip


def latex(text: str) -> str:
    """A text for LaTeX."""
    return re.sub(r"\b(\d[\d.]*)e([-+]?)0*(\d+)\b", r"$\1\\cdot10^{\2\3}$", text.translate(_LATEX))


def finite(value: float) -> float | None:
    """The value, or None if it is NaN or infinite."""
    return value if math.isfinite(value) else None


def numbers(holder: object, *names: str) -> dict[str, float | None]:
    """Attributes that are numbers, for JSON."""
    return {name: finite(getattr(holder, name)) for name in names}


_BEGINNINGS_OF_FORMULAS = ("=", "+", "-", "@", "\t", "\r")


def plain(value: Any) -> Any:
    """Data for JSON: arrays, tuples and tables as lists, what has fields as a dict, None for no number."""
    if isinstance(value, Table):
        return [*value]
    if is_dataclass(value):
        value = {each.name: getattr(value, each.name) for each in fields(value) if each.metadata != UNSAID}
    value = value.tolist() if hasattr(value, "tolist") else str(value) if isinstance(value, Path) else value
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


UNSAID = {"is_said": False}
"""Metadata of a field that JSON leaves out."""


def csv_lines(rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Rows as CSV; None is an empty field, and text that a spreadsheet would calculate gets an apostrophe."""
    line = io.StringIO()
    writer = csv.writer(line, lineterminator="\n")
    for row in rows:
        writer.writerow(_inert(cell) for cell in row)
        yield line.getvalue()
        line.seek(0)
        line.truncate()


def _inert(cell: Any) -> Any:
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(_BEGINNINGS_OF_FORMULAS) else cell


def group_breaks(keys: Sequence[object]) -> tuple[int, ...]:
    """Positions at which a key differs from the one before."""
    return tuple(position for position in range(1, len(keys)) if keys[position] != keys[position - 1])
