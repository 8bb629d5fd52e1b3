"""Usual names of columns in measured files."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_units import is_counts, known_unit, unit_by_name
from hydrofdi.records.measured.formats.table import Table, split_title
from hydrofdi.units import parse_unit

NAMES = {
    Channel.CHAMBER_1_PRESSURE: "p1, pa, pressure 1, chamber 1 pressure, chamber pressure 1, p chamber 1",
    Channel.CHAMBER_2_PRESSURE: "p2, pb, pressure 2, chamber 2 pressure, chamber pressure 2, p chamber 2",
    Channel.SUPPLY_PRESSURE: "ps, p supply, supply pressure, pressure supply",
    Channel.RETURN_PRESSURE: "pr, pt, p return, p tank, return pressure, tank pressure",
    Channel.PISTON_POSITION: "x, xp, position, piston position, stroke, displacement",
    Channel.PISTON_VELOCITY: "v, vp, velocity, piston velocity",
    Channel.SPOOL_POSITION: "xv, xs, spool, spool position, valve position",
    Channel.INPUT_VOLTAGE: "u, voltage, input voltage, command, command voltage, control voltage"
    ", valve command",
}
"""Channel → its usual column names; upper and lower case, blanks, ``_``, ``-`` and ``.`` do not matter."""

_CHANNELS = {name.replace(" ", ""): channel for channel, text in NAMES.items() for name in text.split(", ")}
_TIMES = ("time", "t")
"""Names of time columns, the preferred one first."""
_DATES = {"timestamp", "datetime", "zeit", "zeitstempel"}
"""Names of time columns that contain dates."""


def channel_of(table: Table, position: int) -> Channel | None:
    """The channel that a column's title means; None if there is none, or the unit has another dimension."""
    return channel_named(table.titles[position], table.unit(position))


def channel_named(title: str, unit: str) -> Channel | None:
    """The channel that a title means; None if there is none, or the unit has another dimension."""
    channel = _CHANNELS.get(short_name(title))
    if channel is None or is_counts(unit) or (found := known_unit(unit)) is None:
        return channel
    return channel if found.exponents == parse_unit(channel.unit).exponents else None


def named_like_time(table: Table) -> list[int]:
    """Columns with the preferred name of time in the table, unless their unit has another dimension."""
    return titles_of_time(table.titles, [table.unit(position) for position in range(len(table.titles))])


def titles_of_time(titles: Sequence[str], units: Sequence[str]) -> list[int]:
    """Positions of the preferred name of time among titles, unless their unit has another dimension."""
    named: dict[str, list[int]] = {name: [] for name in _TIMES}
    for position, (title, text) in enumerate(zip(titles, units, strict=True)):
        unit = known_unit(text)
        if short_name(title) in named and (unit is None or unit.exponents == parse_unit("s").exponents):
            named[short_name(title)].append(position)
    return next((found for found in named.values() if found), [])


def titles_of_dates(titles: Sequence[str], dated: Collection[int]) -> list[int]:
    """Positions of the columns that contain dates and have a name of time."""
    return [n for n, title in enumerate(titles) if n in dated and short_name(title) in _DATES.union(_TIMES)]


def time_columns(table: Table) -> list[int]:
    """Columns that are named like time and state a unit of time."""
    return [position for position in named_like_time(table) if known_unit(table.unit(position)) is not None]


def times_without_unit(table: Table) -> list[int]:
    """Time columns without a unit: columns of dates, or else numbers under the name ``time``."""
    named = titles_of_dates(table.titles, range(len(table.titles)))
    dated = [position for position in named if table.dates(position) is not None]
    return dated or [n for n in named_like_time(table) if not table.unit(n) and unit_by_name(table.titles[n])]


def short_name(title: str) -> str:
    """A title without unit, blanks and punctuation, in lower case."""
    return re.sub(r"[\s_.\-]+", "", split_title(title)[0]).lower()
