"""Descriptions of files: completed from headers, or proposed from headers and first rows as YAML to paste."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records import Array, Channel
from hydrofdi.records.columns import (
    FileColumns,
    RejectionError,
    channel_named,
    column_name,
    columns_of,
    is_unit,
    shortened,
    shown_titles,
    split_title,
    unit_by_name,
)
from hydrofdi.records.defects import update_rate
from hydrofdi.records.description import (
    ChannelConfig,
    FormatConfig,
    MeasuredConfig,
    TimeConfig,
    known_unit,
    unit_mistake,
)
from hydrofdi.records.dialects import (
    CHANNELS,
    below_preamble,
    date_format,
    encoding_of,
    long_form,
    thousands_of,
)
from hydrofdi.records.files import open_table
from hydrofdi.records.rows import MISSING_LIKE
from hydrofdi.records.text import TextTable, last_part
from hydrofdi.records.times import (
    counts_samples,
    is_dated,
    likely_unit,
    named_time,
    require_seconds,
    sampling_of_times,
    time_column,
    titles_of_time,
)
from hydrofdi.units import parse_unit, similar_units, zero_of

_BRIDGED = 10.0
"""Longest step that is interpolated without a question [median steps]."""
_OF_DAY = re.compile(r"\s*\d{1,2}:")
"""A time of day without a date."""
_WITHOUT_UNIT = {"LabVIEW Measurement": "s", "SampleTime[ms]": "ms"}
"""Text above the rows of a program → the unit of its column of time, which it does not state."""


@dataclass
class Proposal:
    """What a file states: its format, its columns by position, and units that stand beside the header."""

    table: FileColumns
    form: dict[str, Any] = field(default_factory=dict)
    names: Sequence[str] = ()
    units: Mapping[int, str] = field(default_factory=dict)

    def lines(self, pattern: str, frequency: float | None) -> Iterator[str]:
        """The description."""
        yield f"files: {pattern!r}"
        channels, time = self.channels(), self._time()
        self.form |= self._missing([*channels.values(), *([] if time is None else [time])])
        if self.form:
            # JSON is YAML; its keys need no quotes
            yield "format: " + re.sub(r'"(\w+)":', r"\1:", json.dumps(self.form, ensure_ascii=False))
        clocks: Mapping[int, int] = {}
        if frequency:
            yield f"sampling_frequency: {frequency:g} Hz"
        elif time is None:
            yield "sampling_frequency: …"
        else:
            clocks = self.table.clocks(time) if isinstance(self.table, TextTable) else {}
            time = next(iter(clocks.values()), time)
            yield from self._time_lines(time, [*channels.values()], has_clocks=bool(clocks))
        used = (*channels.values(), time)
        left = [title for n, title in enumerate(self.names) if n not in used and title]
        if left and "long" not in self.form:
            yield f"# other columns: {shown_titles(left)}"
        yield "channels:"
        for channel, position in channels.items():
            clock = clocks.get(position, time)
            own = f", time: {clock + 1}" if clock is not None and clock != time else ""
            column = self._column(position)
            keys = f"{{column: {column}, unit: {self._unit(position, channel.unit)}{own}}}"
            yield f"  {channel}: {keys}" + f"  # {self.names[position]}" * column.isdigit()
        if not channels:
            yield "  chamber_1_pressure: {column: '…', unit: …}"

    def channels(self) -> dict[Channel, int]:
        """Channel → the first column that is named like it."""
        positions: dict[Channel, int] = {}
        for position, title in enumerate(self.names):
            if channel := channel_named(title, self._stated_unit(position), CHANNELS):
                positions.setdefault(channel, position)
        return positions

    def units_beside(self, above: Sequence[Sequence[str]]) -> Iterator[tuple[int, str]]:
        """Units in a line above the rows that has one per channel; the time of programs that state none."""
        channels = self.channels()
        for cells in above:
            texts = [split_title(cell.strip())[0] for cell in cells]
            fits = (n < len(texts) and not unit_mistake(texts[n], own.unit) for own, n in channels.items())
            if channels and all(fits):
                yield from ((n, text) for n, text in enumerate(texts) if is_unit(text))
                break
        units = (unit for text, unit in _WITHOUT_UNIT.items() if any(text in cells for cells in above))
        if unit := next(units, ""):
            yield from ((n, unit) for n, name in enumerate(self.names) if name == self.names[0])

    def _column(self, position: int) -> str:
        """A column as it is written: numbers without quotes."""
        column = column_name(self.table.titles, position)
        return column if column.isdecimal() else repr(column)

    def _stated_unit(self, position: int) -> str:
        return self.table.unit(position) or self.units.get(position, "")

    def _unit(self, position: int, si_unit: str) -> str:
        """The unit of a column, or an ellipsis."""
        header = self._stated_unit(position) or unit_by_name(self.names[position])
        similar = similar_units(header, si_unit)
        return header if is_unit(header) else similar[0] if len(similar) == 1 else "…"

    def _missing(self, positions: Sequence[int]) -> dict[str, Any]:
        """Texts in the columns that programs write for missing values."""
        if not isinstance(self.table, TextTable):
            return {}
        with suppress(DataError, RejectionError):
            self.table.load([n for n in positions if not self.table.is_dated(n)])
            return {}
        tokens = self.table.tokens(MISSING_LIKE)
        return {"missing": tokens} if tokens else {}

    def _time(self) -> int | None:
        """A column that may be the time by its name, its dates or its unit, or else the first if it rises."""
        table, second = self.table, parse_unit("s").exponents
        units = [known_unit(self._stated_unit(n)) for n in range(len(table.titles))]
        others = [n for n, unit in enumerate(units) if unit and unit.exponents == second]
        others += [n for n in range(len(units)) if table.is_dated(n)]
        first = [] if 0 in self.channels().values() else range(len(units))[:1]
        rising = (n for n in first if _rises(_numbers(table, n)))
        return next((n for n in [*named_time(table), *others, *rising] if not self._is_no_time(n)), None)

    def _is_no_time(self, position: int) -> bool:
        """Whether all numbers are missing, or count the samples."""
        values = _numbers(self.table, position)
        is_counter = values is not None and not self.table.unit(position) and counts_samples(values)
        return is_counter or (values is not None and not np.isfinite(values).any())

    def _time_lines(self, time: int, channels: Sequence[int], *, has_clocks: bool) -> Iterator[str]:
        """The column of time, and what makes it even, with how often channels are really updated."""
        table, unit, remark = self.table, "", ""
        if table.is_dated(time):
            more, remark = self._date_keys(time)
        else:
            unit = self._stated_unit(time)
            unit = unit if is_unit(unit) else "".join(similar_units(unit, "s")[:1])
            with suppress(DataError):
                if not unit and (unit := likely_unit(values := table.numbers(time))):
                    steps = np.diff(values[np.isfinite(values)]) * float(parse_unit(unit).factor)
                    rate = f"{1.0 / np.median(steps):.4g} Hz " if steps.size else ""
                    remark = f"  # no unit is stated; {rate}if it is {unit}"
            more = f", unit: {unit or '…'}"
        yield f"time: {{column: {self._column(time)}{more}}}{remark}"
        with suppress(DataError, RejectionError, ValueError):
            times = table.instants(time)[0]
            times = times * float(parse_unit(unit).factor) + zero_of(unit) if unit else times
            if times.size < 2 or has_clocks:
                return
            frequency, remarks = sampling_of_times(times, MeasuredConfig(files=("…",)), table)
            if any(issue.is_unusable for issue in remarks):
                slow = [
                    f"{shortened(self.names[n])} is updated at {held:.3g} Hz"
                    for n in channels
                    if (own := _numbers(table, n)) is not None and (held := update_rate(own, times))
                ]
                steps = np.diff(times)
                is_long = bool(steps.max() > _BRIDGED * np.median(steps))
                slow += [f"it would draw a line through {steps.max():.3g} s without samples"] * is_long
                line = f"resample: {float(f'{frequency:.3g}'):g} Hz" + f"  # {'; '.join(slow)}" * bool(slow)
                yield "# " * is_long + line

    def _date_keys(self, time: int) -> tuple[str, str]:
        """Column and format of dates, if they must be stated, and a remark on them."""
        table = self.table
        if not isinstance(table, TextTable):
            return "", ""
        dates = [n for n, name in enumerate(self.names) if name.lower() in ("date", "datum") and n != time]
        rows = [row for row in table.example if len(row) > max([time, *dates]) and is_dated(row[time])]
        date = dates[0] if dates and rows and _OF_DAY.match(rows[0][time]) else None
        texts = [row[time] if date is None else f"{row[date].strip()} {row[time].strip()}" for row in rows]
        form, is_ambiguous = date_format(texts) or ("…", False)
        table.date_by(time, form, date)
        keys = ("" if date is None else f", date: {self._column(date)}") + (
            f", format: {form!r}" if form else ""
        )
        return keys, "  # day and month may be the other way round" if is_ambiguous else ""


def _numbers(table: FileColumns, position: int) -> Array | None:
    """Numbers of a column; None of dates and of texts."""
    with suppress(DataError):
        return None if table.is_dated(position) else table.numbers(position)
    return None


def _rises(values: Array | None) -> bool:
    known = np.empty(0) if values is None else values[np.isfinite(values)]
    return values is not None and values.size > 2 and bool(np.all(np.diff(known) > 0.0))


def proposed_description(file: Path, pattern: str, frequency: float | None = None) -> str:
    """YAML of a description of files with what one of them states; an ellipsis stands for the rest."""
    try:
        proposal = _proposal(file)
        opened = open_table(file, str(file), FormatConfig(**proposal.form))
        with np.errstate(all="ignore"), opened as proposal.table:
            titles = proposal.table.titles
            proposal.names = [*proposal.names[: len(titles)], *titles[len(proposal.names) :]]
            return "\n".join(proposal.lines(pattern, frequency))
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None


def _proposal(file: Path) -> Proposal:
    encoding = encoding_of(file)
    skip, table = below_preamble(file, encoding)
    if not isinstance(table, TextTable):
        return Proposal(table, names=[title.rpartition("/")[2] for title in table.titles])
    defaults, form = FormatConfig(), dict[str, Any]()
    form |= {"skip": skip} if skip != defaults.skip else {}
    form |= {"encoding": encoding} if encoding != defaults.encoding else {}
    names = [title if is_unit(title.rpartition("/")[2]) else last_part(title) for title in table.titles]
    proposal = Proposal(table, form, names)
    first = table.first_numeric
    if signs := thousands_of(first[1] if first else []):
        form |= signs
    elif table.has_decimal_commas:
        form["decimal"] = ","
    if table.units_in_cells:
        form["units_in_cells"] = True
    if proposal.channels():
        proposal.units = dict(proposal.units_beside(table.lines_above(first[0]) if first else []))
        if first and table.n_between:
            form |= {"skip": first[0] - 1, "header": False}
    elif long := long_form(table):
        form["long"] = long
        with open_table(file, str(file), FormatConfig(**form)) as pivoted:
            proposal.names = pivoted.titles
    return proposal


def completed(
    config: MeasuredConfig, files: Sequence[Path], *, is_plain: bool = False
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    """A description with the channels that the first readable file states, and a remark on unused columns.

    Its sampling is kept; if it `is_plain`, a column of time beside a sampling frequency is refused. Without a
    readable file it has no channels.
    """
    for file in files:
        table_of = open_table(file, str(file), config.format)
        with suppress(RejectionError), np.errstate(all="ignore"), table_of as table:
            if not table.titles:
                raise DataError(f"{file}: contains no columns")
            return _completed(config, table, file, is_plain)
    return config, ()


def _completed(
    config: MeasuredConfig, table: FileColumns, file: Path, is_plain: bool
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    titles = table.titles
    try:
        used = {channel: named.position for channel, named in columns_of(table, {}).items()}
        channels = {name: ChannelConfig(column=column_name(titles, n)) for name, n in used.items()}
        time = config.time
        times = [] if time is None else [table.find(time.column)]
        if time is None and config.sampling_frequency is None:
            times = [_time_in(table, file)]
            time = TimeConfig(column=column_name(titles, times[0]))
    except DataError as error:
        what = str(error).removeprefix(f"{file}: ")
        advice = indent(proposed_description(file, file.name), "    ")
        raise DataError(f"{file}: {what}; describe it in a YAML file:\n{advice}") from None
    if config.sampling_frequency is not None:
        times = [n for n in titles_of_time(table) if known_unit(table.unit(n))]
        if times and is_plain:
            raise DataError(f"{file}: has a column {titles[times[0]]!r}; leave the sampling frequency out")
    left = [title for n, title in enumerate(titles) if n not in (*used.values(), *times)]
    unused = (Issue(f"columns not used: {shown_titles(left)}", kind="unused"),) if left else ()
    return config.model_copy(update={"channels": channels, "time": time}), unused


def _time_in(table: FileColumns, file: Path) -> int:
    """Position of the column of time."""
    time = time_column(table, None)
    if time is None:
        message = (
            "no sampling frequency is given (sampling_frequency=1kHz), and no column is named 'time [s]'"
        )
        raise DataError(f"{file}: {message}")
    if not (table.unit(time.position) or table.is_dated(time.position)):
        require_seconds(table.numbers(time.position), f"{file}: column {time.title[:60]!r}")
    return time.position
