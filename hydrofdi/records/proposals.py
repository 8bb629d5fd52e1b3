"""Descriptions that are proposed for files: what their headers and first rows state, in YAML to paste."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array, Channel
from hydrofdi.records.columns import (
    MOST_SHOWN,
    RejectionError,
    Table,
    channel_named,
    is_unit,
    shortened,
    split_title,
    unit_by_name,
)
from hydrofdi.records.description import FormatConfig, MeasuredConfig, known_unit, unit_mistake
from hydrofdi.records.long import last_part
from hydrofdi.records.opening import open_table
from hydrofdi.records.rows import MISSING_LIKE
from hydrofdi.records.stuck import update_rate
from hydrofdi.records.text import TextTable
from hydrofdi.records.times import counts_samples, likely_unit, named_time, sampling_of_times
from hydrofdi.units import parse_unit, similar_units, zero_of

_SUGGESTED = {
    Channel.CHAMBER_1_PRESSURE: "druck a, druck 1, pressure a, kammerdruck a, kammerdruck 1",
    Channel.CHAMBER_2_PRESSURE: "druck b, druck 2, pressure b, kammerdruck b, kammerdruck 2",
    Channel.SUPPLY_PRESSURE: "druck p, pressure p, versorgungsdruck, systemdruck",
    Channel.RETURN_PRESSURE: "druck t, pressure t, tankdruck",
    Channel.PISTON_POSITION: "weg, hub, kolbenweg, kolbenposition",
    Channel.PISTON_VELOCITY: "geschwindigkeit, kolbengeschwindigkeit",
    Channel.INPUT_VOLTAGE: "spannung, stellspannung, ventil, ventilspannung, valve, command",
}
"""Names for which a description is only suggested, because they are ambiguous."""
_CHANNELS = {
    name.replace(" ", ""): channel for channel, text in _SUGGESTED.items() for name in text.split(", ")
}
_LONGEST_PREAMBLE = 40
"""Lines among which the header of a text file is looked for."""
_WITHOUT_UNIT = {"LabVIEW Measurement": "s", "SampleTime[ms]": "ms"}
"""Text above the rows of a program → the unit of its column of time, which it does not state."""
_VALUES = ("state", "value", "varvalue", "wert")
"""Names of the column of values in tables with a row for each of them."""
_THOUSANDS = {
    re.compile(r"[-+]?\d{1,3}(,\d{3})+\.\d+"): (",", "."),
    re.compile(r"[-+]?\d{1,3}(\.\d{3})+,\d+"): (".", ","),
}
"""Cells that have both signs → the sign of thousands and the decimal sign."""


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
            if channel := channel_named(title, unit, _CHANNELS):
                found.setdefault(channel, position)
        return found


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
    channels, time = found.channels(), _time(found)
    found.form |= _missing(found, [*channels.values(), *([] if time is None else [time])])
    if found.form:
        yield f"format: {_flow(found.form)}"
    clocks: dict[int, int] = {}
    if frequency:
        yield f"sampling_frequency: {frequency:g} Hz"
    elif time is None:
        yield "sampling_frequency: …"
    else:
        clocks = _clocks(found, time)
        time = min(set(clocks.values()), key=lambda each: _step(found.table, each)) if clocks else time
        yield from _time_lines(found, time, [*channels.values()], has_clocks=bool(clocks))
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


def _time(found: Proposal) -> int | None:
    """A column that may be the time by its name, its dates or its unit, or else the first if it rises."""
    table, second = found.table, parse_unit("s").exponents
    units = [known_unit(table.unit(n) or found.units.get(n, "")) for n in range(len(table.titles))]
    others = [n for n, unit in enumerate(units) if unit and unit.exponents == second]
    others += [n for n in range(len(units)) if table.is_dated(n)]
    rising = (n for n in [0] if n not in found.channels().values() and _rises(table, n))
    return next((n for n in [*named_time(table), *others, *rising] if not is_counter(table, n)), None)


def _rises(table: Table, position: int) -> bool:
    with suppress(DataError):
        values = table.numbers(position)
        return values.size > 2 and bool(np.all(np.diff(values[np.isfinite(values)]) > 0.0))
    return False


def is_counter(table: Table, position: int) -> bool:
    """Whether a column without a unit counts the samples."""
    if table.unit(position) or table.is_dated(position):
        return False
    with suppress(DataError):
        return counts_samples(table.numbers(position))
    return False


def _clocks(found: Proposal, time: int) -> dict[int, int]:
    """Position of a channel → that of its own time, if more than one column has the name of the time."""
    times = [n for n, name in enumerate(found.names) if name == found.names[time]]
    if len(times) < 2:
        return {}
    return {n: max(each for each in times if each < n) for n in found.channels().values() if n > times[0]}


def _step(table: Table, time: int) -> float:
    return float(np.nanmedian(np.diff(table.instants(time)[0])))


def _time_lines(found: Proposal, time: int, channels: Sequence[int], *, has_clocks: bool) -> Iterator[str]:
    """The column of time, and what makes it even, with how often channels are really updated."""
    table, date = found.table, ""
    if table.is_dated(time):
        with suppress(DataError):
            is_of_day = math.isnan(table.instants(time)[1])
            dates = [n for n, name in enumerate(found.names) if name.lower() in ("date", "datum")]
            date = f", date: {found.named(dates[0])}" if is_of_day and dates else ""
        yield f"time: {{column: {found.named(time)}{date}}}"
        unit = ""
    else:
        unit = table.unit(time) or found.units.get(time, "")
        with suppress(DataError):
            unit = unit or likely_unit(table.numbers(time)) or "…"
        yield f"time: {{column: {found.named(time)}, unit: {unit or '…'}}}"
    with suppress(DataError, RejectionError, ValueError):
        times = table.instants(time)[0]
        times = times * float(parse_unit(unit).factor) + zero_of(unit) if unit else times
        remarks = sampling_of_times(times, MeasuredConfig(files=("…",)), table)[1]
        if any(each.is_unusable for each in remarks) and not has_clocks:
            rates = [(n, _update_rate(table, n, times)) for n in channels]
            slow = [f"{shortened(found.names[n])} is updated at {rate:.3g} Hz" for n, rate in rates if rate]
            rate = float(f"{1.0 / float(np.median(np.diff(times))):.3g}")
            yield f"resample: {rate:g} Hz" + f"  # {'; '.join(slow)}" * bool(slow)


def _update_rate(table: Table, position: int, times: Array) -> float | None:
    with suppress(DataError):
        return update_rate(table.numbers(position), times)
    return None


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
    skip, table = below_preamble(file)
    if not isinstance(table, TextTable):
        return Proposal(table, names=[title.rpartition("/")[2] for title in table.titles])
    found = Proposal(table, {"skip": skip} if skip else {}, table.titles)
    first = table.first_numeric
    row = first[1] if first else []
    thousands = (signs for cell in row for form, signs in _THOUSANDS.items() if form.fullmatch(cell.strip()))
    if signs := next(thousands, None):
        found.form |= {"thousands": signs[0]} | ({"decimal": ","} if signs[1] == "," else {})
    elif table.has_decimal_commas:
        found.form["decimal"] = ","
    if table.units_in_cells:
        found.form["units_in_cells"] = True
    if found.channels():
        above = table.lines_above(first[0]) if first else []
        found.units = dict(_units_beside(found, above))
        if first and table.n_between:
            found.form |= {"skip": first[0] - 1, "header": False}
    elif long := _long(table):
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


def _long(table: TextTable) -> dict[str, str] | None:
    """Columns of names and values, if names of channels stand in the rows."""
    titles = table.titles
    for position in range(len(titles)):
        texts = {row[position].strip() for row in table.example if position < len(row)}
        if any(channel_named(last_part(text), "", _CHANNELS) for text in texts):
            values = [title for title in titles if title.lower() in _VALUES]
            return {"name": titles[position], "value": values[0]} if values else None
    return None


def below_preamble(file: Path) -> tuple[int, Table]:
    """Number of lines above the header, and the table: it names channels right above numbers, or most of them
    farther above, or else none."""
    found: list[tuple[int, int, Table]] = []
    for skip in range(_LONGEST_PREAMBLE):
        with suppress(DataError), open_table(file, str(file), FormatConfig(skip=skip)) as table:
            if not isinstance(table, TextTable):
                return skip, table
            titles = enumerate(table.titles if table.has_numbers else ())
            n_named = sum(channel_named(title, table.unit(n), _CHANNELS) is not None for n, title in titles)
            if n_named and not table.n_between and table.first_numeric:
                return skip, table
            found += [(n_named, -skip, table)] * table.has_numbers
    if found:
        _, skip, table = max(found, key=lambda each: each[:2])
        return -skip, table
    with open_table(file, str(file), FormatConfig()) as table:
        return 0, table
