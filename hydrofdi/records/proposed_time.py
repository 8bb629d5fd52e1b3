"""What a file states of its columns, and the column of time that is proposed for it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array, Channel
from hydrofdi.records.columns import (
    RejectionError,
    Table,
    channel_named,
    is_unit,
    shortened,
    split_title,
    unit_by_name,
)
from hydrofdi.records.defects import update_rate
from hydrofdi.records.description import MeasuredConfig, known_unit
from hydrofdi.records.dialects import CHANNELS, date_format
from hydrofdi.records.text import TextTable
from hydrofdi.records.times import counts_samples, is_dated, likely_unit, named_time, sampling_of_times
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
