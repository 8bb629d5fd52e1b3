"""Usual names of columns in measured files."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from fractions import Fraction

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import ChannelConfig
from hydrofdi.records.measured.formats.table import Table, split_title
from hydrofdi.units import Unit, parse_unit, similar_units

_COUNTS = {"counts", "count", "cts", "lsb"}
_SI_BY_NAME = {channel.value: channel.unit for channel in Channel} | {"time": "s"}
_EXACT = 2**53


def is_counts(unit: str) -> bool:
    """Whether a unit means the counts of a converter."""
    return unit.lower() in _COUNTS


def is_unit(text: str) -> bool:
    """Whether a text is a unit, or the dash of a column without one."""
    return text == "-" or is_counts(text) or known_unit(text) is not None


def known_unit(text: str) -> Unit | None:
    """The unit that a text means; None if hydrofdi does not know it."""
    try:
        return parse_unit(text)
    except ValueError:
        return None


def unit_by_name(column: str) -> str:
    """SI unit of a column under a channel's full name, or ``time``; empty for other names.

    Such columns are in SI if neither file nor description states a unit.
    """
    return _SI_BY_NAME.get(column, "")


def agreed_unit(config: ChannelConfig, header: str, where: str) -> str:
    """Unit of a channel after gain and offset.

    Parameters
    ----------
    config : ChannelConfig
    header : str
        Unit that the file states; empty if it states none.
    where : str
        File and column, for messages.

    Raises
    ------
    DataError
        Description, header and name state none, or file and description disagree.
    """
    if config.unit and (config.gain is not None or _may_agree(config.unit, header)):
        return config.unit
    if config.unit:
        raise DataError(
            f"{where}: the file says {header}, the description says {config.unit};"
            " leave 'unit' out, or give the 'gain' between them"
        )
    header = header or unit_by_name(config.column)
    if not header:
        raise DataError(f"{where}: has no unit; write 'unit: …', such as bar, or 'unit: counts'")
    if config.gain is not None and not is_counts(header):
        raise DataError(f"{where}: a gain needs a unit; write the 'unit' after the gain")
    return header


def unknown_header_unit(config: ChannelConfig, header: str) -> tuple[Issue, ...]:
    """A remark if the header's unit is not known, so that only the description states the scale."""
    is_checked = not header or is_unit(header) or len(_readings(config.unit, header)) == 1
    if is_checked or not config.unit or config.gain is not None or " " in header:
        return ()
    text = f"column {config.column!r}: the header says {header!r}, the description {config.unit!r}"
    return (Issue(text, kind="unknown_unit"),)


def calibrated(values: Array, config: ChannelConfig) -> Array:
    """Values of a column with its gain, offset and sign, in the unit of its configuration."""
    if config.gain is not None:
        values = config.gain * values
    if config.offset:
        values = values + config.offset
    return -values if config.sign < 0 else values


def in_si(values: Array, unit: str, si_unit: str, where: str) -> Array:
    """Values in SI; unchanged if the unit is counts.

    Raises
    ------
    DataError
        The unit is unknown, or of another dimension.
    """
    return scaled(values, factor_to_si(unit, si_unit, where))


def factor_to_si(unit: str, si_unit: str, where: str) -> Fraction:
    """Factor from a unit to SI; one for counts.

    Raises
    ------
    DataError
        The unit is unknown, or of another dimension.
    """
    if is_counts(unit):
        return Fraction(1)
    found, wanted = known_unit(unit), parse_unit(si_unit)
    if found is None:
        raise DataError(f"{where}: unknown unit {unit!r}{unit_remedy(unit, si_unit)}")
    if found.exponents != wanted.exponents:
        raise DataError(f"{where}: the unit {unit} is not convertible to {si_unit}")
    return found.factor / wanted.factor


def scaled(values: Array, factor: Fraction) -> Array:
    """Values times an exact factor, rounded once if numerator or denominator is one."""
    numerator, denominator = factor.numerator, factor.denominator
    if max(numerator, denominator) > _EXACT:
        return np.asarray(values * float(factor))
    product = values if numerator == 1 else values * float(numerator)
    return product if denominator == 1 else product / float(denominator)


def unit_remedy(unit: str, si_unit: str) -> str:
    """Hint on an unknown unit: similar units, or else how to state the scale."""
    if similar := similar_units(unit, si_unit):
        return f"; did you mean {' or '.join(map(repr, similar))}?"
    return "; give 'gain' and the 'unit' after the gain, or 'unit: counts' if the scale is unknown"


def _may_agree(unit: str, header: str) -> bool:
    """Whether a header's unit is that of the description, or hydrofdi cannot tell."""
    if is_unit(header):
        return _same(unit, header)
    readings = _readings(unit, header)
    return not readings or known_unit(unit) in readings


def _readings(unit: str, header: str) -> set[Unit]:
    """Units of the dimension of `unit` that an unknown header may mean."""
    if known_unit(unit) is None:
        return set()
    return {parse_unit(similar) for similar in similar_units(header, unit)}


def _same(one: str, other: str) -> bool:
    if is_counts(one) or is_counts(other):
        return is_counts(one) and is_counts(other)
    return known_unit(one) == known_unit(other)


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
