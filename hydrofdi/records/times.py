"""The column of time, and its unit."""

from __future__ import annotations

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.columns import (
    ReadColumn,
    Table,
    Titled,
    column_at,
    factor_to_si,
    find_column,
    scaled,
    short_name,
    shortened,
    unit_by_name,
)
from hydrofdi.records.dates import FIRST_DATE, LAST_DATE
from hydrofdi.records.description import ChannelConfig, TimeConfig, is_counts, known_unit
from hydrofdi.units import ABOVE, BELOW, parse_unit, zero_of

_SECOND = parse_unit("s")
_TIMES = ("time", "t", "timestamps")
"""Names of time columns, the preferred one first."""
_DATES = {"timestamp", "datetime", "zeit", "zeitstempel", *_TIMES}
"""Names of time columns that contain dates."""


def time_column(table: Titled, configured: TimeConfig | None) -> ReadColumn | None:
    """The column of time, as configured, or else by its name; None if there is none.

    Dates need no unit, and ``time`` is in seconds if none is stated.
    """
    if configured is not None:
        found = [find_column(table.titles, configured.column, table.place)]
    elif clocks := table.clocks():
        found = [next(iter(clocks.values()))]
    elif len(found := named_time(table)) > 1:
        names = ", ".join(shortened(table.titles[n]) for n in found)
        raise DataError(f"{table.place}: has more than one column of time: {names}")
    if not found:
        return None
    position, title = found[0], table.titles[found[0]]
    config = ChannelConfig(column=title, unit=configured.unit if configured else "")
    are_dates, header = table.is_dated(position), table.unit(position)
    header = "" if are_dates and not known_unit(header) else header
    if are_dates and not (header or config.unit or unit_by_name(title)):
        return ReadColumn(position, title, config, "", None)
    column = column_at(table, position, config, "s", header)
    if is_counts(column.unit):
        message = "counts the samples and is not a time; give the sampling frequency instead"
        raise DataError(f"{table.place}: column {title[:60]!r}: {message}")
    return column


def named_time(table: Titled) -> list[int]:
    """Columns with a name of time: numbers with a unit are preferred to dates."""
    titles = table.titles
    dated = [n for n, title in enumerate(titles) if short_name(title) in _DATES and table.is_dated(n)]
    named = titles_of_time(table)
    usable = [n for n in named if n in dated or table.unit(n) or unit_by_name(titles[n])]
    return usable or dated or named


def titles_of_time(table: Titled) -> list[int]:
    """Positions of the preferred name of time among titles, unless their unit has another dimension."""
    named: dict[str, list[int]] = {name: [] for name in _TIMES}
    for position, name in enumerate(map(short_name, table.titles)):
        unit = known_unit(table.unit(position)) if name in named else None
        if name in named and (unit is None or unit.exponents == _SECOND.exponents):
            named[name].append(position)
    return next((found for found in named.values() if found), [])


def counts_samples(values: Array) -> bool:
    """Whether a column rises by one from sample to sample: a counter, if it has no unit."""
    return values.size > 1 and bool(np.all(np.diff(values) == 1.0))


_USUAL_RATES, _FAST = (20.0, 1e6), 20e3
"""Rates [Hz] at which a time without a unit is believed to be in seconds; above the last one, unless another
unit gives a round rate below it."""
_ROUND = (1.0, 2.0, 2.5, 4.0, 5.0, 10.0)
"""What round rates begin with."""
_LIKELY_UNITS = ("s", "ms", "µs", "ns", "min", "h", "day", "FILETIME", "exceldays")
_FEWEST = 10


def likely_unit(values: Array) -> str:
    """The unit in which a column of time is a date, or else has a usual rate; seconds if its rate cannot be
    seen; empty if no unit is likely, or more than one."""
    known = values[np.isfinite(values)]
    steps = np.diff(known)
    if known.size < _FEWEST or not (step := float(np.median(steps))) > 0.0:
        return "s"
    mean, likely, rounded = float(known[-1] - known[0]) / steps.size, list[str](), list[str]()
    for unit in _LIKELY_UNITS:
        factor, zero = float(parse_unit(unit).factor), zero_of(unit)
        rate = 1.0 / (factor * step)
        if not BELOW * _USUAL_RATES[0] <= rate <= ABOVE * _USUAL_RATES[1]:
            continue
        if FIRST_DATE <= factor * known[0] + zero <= LAST_DATE:
            return unit
        if not zero and (rate <= ABOVE * _FAST or unit == "s"):
            likely.append(unit)
            first = [float(f"{1.0 / (factor * each):.3e}"[:5]) for each in (step, mean)]
            rounded += [unit] * any(abs(each / usual - 1.0) < 2e-3 for each in first for usual in _ROUND)
    if likely[:1] == ["s"]:
        others = [unit for unit in rounded if unit != "s"]
        return others[0] if 1.0 / step > ABOVE * _FAST and others else "s"
    found = likely if len(likely) == 1 else rounded
    return found[0] if len(found) == 1 else ""


def require_seconds(values: Array, where: str) -> None:
    """Refuse a time without a unit that is no time in seconds."""
    if (unit := likely_unit(values)) != "s":
        rate = 1.0 / float(np.median(np.diff(values)))
        hint = f"is it in {unit} ({rate / float(parse_unit(unit).factor):.4g} Hz)? " if unit else ""
        raise DataError(
            f"{where}: has no unit, and {rate:.4g} Hz if it is in seconds; {hint}State the unit, as in"
            f" 'time [{unit or 's'}]' or 'time: {{column: …, unit: {unit or 's'}}}'; s, if that is right"
        )


_TOLERANCE = 0.01
"""Share by which a stated sampling frequency may differ from a column of time."""


def contradicting_times(table: Table, frequency: float) -> tuple[Issue, ...]:
    """A remark if median and mean step of a time column contradict the stated sampling frequency."""
    for position in (n for n in titles_of_time(table) if known_unit(table.unit(n))):
        title = table.titles[position]
        try:
            values = table.numbers(position)
        except DataError:
            continue
        times = scaled(values, factor_to_si(table.unit(position), "s", title))
        steps = np.diff(times[np.isfinite(times)])
        expected = np.array([np.median(steps), np.mean(steps)]) * frequency if steps.size else np.ones(2)
        if np.all(np.abs(expected - 1.0) > _TOLERANCE):
            with np.errstate(divide="ignore"):
                found = frequency / expected[0]
            text = f"column {title!r} says {found:g} Hz, the description {frequency:g} Hz"
            return (Issue(text, kind="sampling_differs"),)
    return ()
