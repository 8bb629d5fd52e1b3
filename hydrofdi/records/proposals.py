"""Descriptions of files: completed from headers, or proposed from headers and first rows as YAML to paste."""

from __future__ import annotations

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
    MOST_SHOWN,
    RejectionError,
    Table,
    channel_named,
    columns_of,
    is_unit,
    shortened,
    split_title,
    unit_by_name,
)
from hydrofdi.records.data_sheet import usual_sheet_lines
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


@dataclass
class Proposal:
    """What a file states: its format, its columns by position, and units that stand beside the header."""

    table: Table
    form: dict[str, Any] = field(default_factory=dict)
    names: Sequence[str] = ()
    units: Mapping[int, str] = field(default_factory=dict)

    def named(self, position: int) -> str:
        """A column as a description names it: by its number if the file has no header, or the name twice."""
        names = [split_title(title)[0] for title in self.table.titles]  # paths, in files of arrays
        is_numbered = self.form.get("header") is False or names.count(names[position]) > 1
        return str(position + 1) if is_numbered or not names[position] else f"{shortened(names[position])!r}"

    def unit(self, position: int, si_unit: str) -> str:
        """The unit of a column, or an ellipsis."""
        title = self.names[position]
        header = self.table.unit(position) or self.units.get(position, "") or unit_by_name(title)
        similar = similar_units(header, si_unit)
        return header if is_unit(header) else similar[0] if len(similar) == 1 else "…"

    def channels(self) -> dict[Channel, int]:
        """Channel → the first column that is named like it."""
        found: dict[Channel, int] = {}
        for position, title in enumerate(self.names):
            unit = self.table.unit(position) or self.units.get(position, "")
            if channel := channel_named(title, unit, CHANNELS):
                found.setdefault(channel, position)
        return found


def time_of(found: Proposal) -> int | None:
    """A column that may be the time by its name, its dates or its unit, or else the first if it rises."""
    table, second = found.table, parse_unit("s").exponents
    units = [known_unit(table.unit(n) or found.units.get(n, "")) for n in range(len(table.titles))]
    others = [n for n, unit in enumerate(units) if unit and unit.exponents == second]
    others += [n for n in range(len(units)) if table.is_dated(n)]
    rising = (n for n in [0] if n not in found.channels().values() and _rises(table, n))
    return next((n for n in [*named_time(table), *others, *rising] if not _is_no_time(table, n)), None)


def _rises(table: Table, position: int) -> bool:
    with suppress(DataError):
        values = table.numbers(position)
        return values.size > 2 and bool(np.all(np.diff(values[np.isfinite(values)]) > 0.0))
    return False


def _is_no_time(table: Table, position: int) -> bool:
    with suppress(DataError):
        values = np.zeros(1) if table.is_dated(position) else table.numbers(position)
        return not np.isfinite(values).any() or (not table.unit(position) and counts_samples(values))
    return False


def is_counter(table: Table, position: int) -> bool:
    """Whether a column without a unit counts the samples."""
    if table.unit(position) or table.is_dated(position):
        return False
    with suppress(DataError):
        return counts_samples(table.numbers(position))
    return False


def clocks_of(found: Proposal, time: int) -> dict[int, int]:
    """Position of a channel → that of its own time, if more than one column has the name of the time."""
    times = [n for n, name in enumerate(found.names) if name == found.names[time]]
    if len(times) < 2:
        return {}
    return {n: max(each for each in times if each < n) for n in found.channels().values() if n > times[0]}


def step_of(table: Table, time: int) -> float:
    """Median step of a column of time, in its unit or of dates in seconds."""
    return float(np.nanmedian(np.diff(table.instants(time)[0])))


def time_lines(found: Proposal, time: int, channels: Sequence[int], *, has_clocks: bool) -> Iterator[str]:
    """The column of time, and what makes it even, with how often channels are really updated."""
    table, unit, remark = found.table, "", ""
    if table.is_dated(time):
        more, remark = _date_keys(found, time)
    else:
        unit = table.unit(time) or found.units.get(time, "")
        unit = unit if is_unit(unit) else "".join(similar_units(unit, "s")[:1])
        with suppress(DataError):
            if not unit and (unit := likely_unit(values := table.numbers(time))):
                steps = np.diff(values[np.isfinite(values)]) * float(parse_unit(unit).factor)
                rate = f"{1.0 / np.median(steps):.4g} Hz " if steps.size else ""
                remark = f"  # no unit is stated; {rate}if it is {unit}"
        more = f", unit: {unit or '…'}"
    yield f"time: {{column: {found.named(time)}{more}}}{remark}"
    with suppress(DataError, RejectionError, ValueError):
        times = table.instants(time)[0]
        times = times * float(parse_unit(unit).factor) + zero_of(unit) if unit else times
        frequency, remarks = sampling_of_times(times, MeasuredConfig(files=("…",)), table)
        if any(each.is_unusable for each in remarks) and not has_clocks:
            rates = [(n, _update_rate(table, n, times)) for n in channels]
            slow = [f"{shortened(found.names[n])} is updated at {rate:.3g} Hz" for n, rate in rates if rate]
            steps = np.diff(times)
            is_long = bool(steps.max() > _BRIDGED * np.median(steps))
            slow += [f"it would draw a line through {steps.max():.3g} s without samples"] * is_long
            line = f"resample: {float(f'{frequency:.3g}'):g} Hz" + f"  # {'; '.join(slow)}" * bool(slow)
            yield "# " * is_long + line


def _date_keys(found: Proposal, time: int) -> tuple[str, str]:
    """Column and format of dates, if they must be stated, and a remark on them."""
    table = found.table
    if not isinstance(table, TextTable):
        return "", ""
    dates = [n for n, name in enumerate(found.names) if name.lower() in ("date", "datum") and n != time]
    rows = [row for row in table.example if len(row) > max([time, *dates]) and is_dated(row[time])]
    date = dates[0] if dates and rows and _OF_DAY.match(rows[0][time]) else None
    texts = [row[time] if date is None else f"{row[date].strip()} {row[time].strip()}" for row in rows]
    form, is_ambiguous = date_format(texts) or ("…", False)
    table.date_by(time, form, date)
    stated = f", format: {form!r}" if form else ""
    return (
        ("" if date is None else f", date: {found.named(date)}") + stated,
        "  # day and month may be the other way round" if is_ambiguous else "",
    )


def _update_rate(table: Table, position: int, times: Array) -> float | None:
    with suppress(DataError):
        return update_rate(table.numbers(position), times)
    return None


_WITHOUT_UNIT = {"LabVIEW Measurement": "s", "SampleTime[ms]": "ms"}
"""Text above the rows of a program → the unit of its column of time, which it does not state."""


def proposed_description(file: Path, pattern: str, frequency: float | None = None) -> str:
    """YAML of a description of files with what one of them states; an ellipsis stands for the rest."""
    try:
        found = _proposal(file)
        with (
            np.errstate(all="ignore"),
            open_table(file, str(file), FormatConfig(**found.form)) as found.table,
        ):
            titles = found.table.titles
            found.names = [*found.names[: len(titles)], *titles[len(found.names) :]]
            return "\n".join(_lines(found, pattern, frequency))
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None


def _lines(found: Proposal, pattern: str, frequency: float | None) -> Iterator[str]:
    yield f"files: {pattern!r}"
    channels, time = found.channels(), time_of(found)
    found.form |= _missing(found, [*channels.values(), *([] if time is None else [time])])
    if found.form:
        yield f"format: {_flow(found.form)}"
    clocks: dict[int, int] = {}
    if frequency:
        yield f"sampling_frequency: {frequency:g} Hz"
    elif time is None:
        yield "sampling_frequency: …"
    else:
        clocks = clocks_of(found, time)
        time = min(set(clocks.values()), key=lambda each: step_of(found.table, each)) if clocks else time
        yield from time_lines(found, time, [*channels.values()], has_clocks=bool(clocks))
    left = [
        shortened(title)
        for n, title in enumerate(found.names)
        if n not in (*channels.values(), time) and title
    ]
    if left and "long" not in found.form:
        yield f"# other columns: {', '.join(left[:MOST_SHOWN])}{', …' * (len(left) > MOST_SHOWN)}"
    yield "channels:"
    for channel, position in channels.items():
        clock = clocks.get(position, time)
        own = f", time: {clock + 1}" if clock is not None and clock != time else ""
        keys = f"{{column: {found.named(position)}, unit: {found.unit(position, channel.unit)}{own}}}"
        yield f"  {channel}: {keys}" + f"  # {found.names[position]}" * found.named(position).isdigit()
    if not channels:
        yield "  chamber_1_pressure: {column: '…', unit: …}"


def _flow(form: Mapping[str, Any]) -> str:
    def text(value: Any) -> str:
        if isinstance(value, Mapping):
            return _flow(value)
        if isinstance(value, list):
            return f"[{', '.join(map(text, value))}]"
        return str(value).lower() if isinstance(value, bool | int) else f"{value!r}"

    return f"{{{', '.join(f'{key}: {text(value)}' for key, value in form.items())}}}"


def _missing(found: Proposal, positions: Sequence[int]) -> dict[str, Any]:
    """Texts in the columns that programs write for missing values."""
    if not isinstance(found.table, TextTable):
        return {}
    with suppress(DataError, RejectionError):
        found.table.load([n for n in positions if not found.table.is_dated(n)])
        return {}
    tokens = found.table.tokens(MISSING_LIKE)
    return {"missing": tokens} if tokens else {}


def _proposal(file: Path) -> Proposal:
    encoding = encoding_of(file)
    skip, table = below_preamble(file, encoding)
    if not isinstance(table, TextTable):
        return Proposal(table, names=[title.rpartition("/")[2] for title in table.titles])
    form = {"skip": skip, "encoding": encoding}
    defaults = FormatConfig().model_dump()
    found = Proposal(table, {key: value for key, value in form.items() if value != defaults[key]})
    found.names = [title if is_unit(title.rpartition("/")[2]) else last_part(title) for title in table.titles]
    first = table.first_numeric
    if signs := thousands_of(first[1] if first else []):
        found.form |= signs
    elif table.has_decimal_commas:
        found.form["decimal"] = ","
    if table.units_in_cells:
        found.form["units_in_cells"] = True
    if found.channels():
        above = table.lines_above(first[0]) if first else []
        found.units = dict(_units_beside(found, above))
        if first and table.n_between:
            found.form |= {"skip": first[0] - 1, "header": False}
    elif long := long_form(table):
        found.form["long"] = long
        with open_table(file, str(file), FormatConfig(**found.form)) as pivoted:
            found.names = pivoted.titles
    return found


def _units_beside(found: Proposal, above: Sequence[Sequence[str]]) -> Iterator[tuple[int, str]]:
    """Units in a line above the rows that has one for each channel; the time of programs that state none."""
    channels = found.channels()
    for cells in above:
        texts = [split_title(cell.strip())[0] for cell in cells]
        fits = (n < len(texts) and not unit_mistake(texts[n], each.unit) for each, n in channels.items())
        if channels and all(fits):
            yield from ((n, text) for n, text in enumerate(texts) if is_unit(text))
            break
    units = (unit for text, unit in _WITHOUT_UNIT.items() if any(text in cells for cells in above))
    if unit := next(units, ""):
        yield from ((n, unit) for n, name in enumerate(found.names) if name == found.names[0])


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
    config: MeasuredConfig, table: Table, file: Path, is_plain: bool
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    names = [split_title(title)[0] for title in table.titles]

    def column(position: int) -> str:
        """The name without the unit: other files may have the same column in another unit."""
        if names.count(names[position]) == 1 and names[position]:
            return names[position]
        return (
            table.titles[position] if table.titles.count(table.titles[position]) == 1 else str(position + 1)
        )

    try:
        found = columns_of(table, {})
        used = [each.position for each in found.values()]
        channels = {channel: ChannelConfig(column=column(each.position)) for channel, each in found.items()}
        time = config.time
        times = [] if time is None else [table.find(time.column)]
        if time is None and config.sampling_frequency is None:
            times = [_time_in(table, file)]
            time = TimeConfig(column=column(times[0]))
    except DataError as error:
        raise _advised(file, str(error).removeprefix(f"{file}: ")) from None
    if config.sampling_frequency is not None:
        times = [position for position in titles_of_time(table) if known_unit(table.unit(position))]
        if times and is_plain:
            title = table.titles[times[0]]
            raise DataError(f"{file}: has a column {title!r}; leave the sampling frequency out")
    left = [title for n, title in enumerate(table.titles) if n not in (*used, *times)]
    shown = ", ".join(map(shortened, left[:MOST_SHOWN])) + ", …" * (len(left) > MOST_SHOWN)
    unused = (Issue(f"columns not used: {shown}", kind="unused"),) if left else ()
    return config.model_copy(update={"channels": channels, "time": time}), unused


def _time_in(table: Table, file: Path) -> int:
    """Position of the column of time."""
    time = time_column(table, None)
    if time is None:
        message = (
            "no sampling frequency is given (sampling_frequency=1kHz), and no column is named 'time [s]'"
        )
        raise DataError(f"{file}: {message}")
    if is_counter(table, time.position):
        raise DataError(f"{file}: column {time.title!r} counts the samples and is not a time")
    if not (table.unit(time.position) or table.is_dated(time.position)):
        require_seconds(table.numbers(time.position), f"{file}: column {time.title[:60]!r}")
    return time.position


def _advised(file: Path, what: str) -> DataError:
    """The error that something is missing, with a description to paste."""
    lines = indent(proposed_description(file, file.name), "    ")
    return DataError(f"{file}: {what}; describe it in a YAML file:\n{lines}")


def suggested_description(file: Path, pattern: str, sampling_frequency: float | None) -> str:
    """YAML of a description of files with what the headers of one state, and a data sheet as comments."""
    return "\n".join([proposed_description(file, pattern, sampling_frequency), *usual_sheet_lines()]) + "\n"
