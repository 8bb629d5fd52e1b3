"""Columns, and which of them is which channel in which unit: of files, streams and arrays alike."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from hydrofdi.errors import ConfigError, DataError, Issue
from hydrofdi.records import Array, Channel
from hydrofdi.records.description import ChannelConfig, is_counts, known_unit, unit_mistake
from hydrofdi.settings.messages import listed, nearest
from hydrofdi.units import Unit, parse_unit, similar_units, zero_of

_TITLE = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*")
_BEHIND = re.compile(r"(.+)[_/]([^_/]+)")
_IN = re.compile(r"(.*\S)\s+in\s+(\S+)")
_MOST_SHOWN = 12
_LONGEST_TITLE = 1000
"""Most characters of a header that is split into name and unit."""
_SI_BY_NAME = {channel.value: channel.unit for channel in Channel} | {"time": "s"}
_EXACT = 2**53

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
    Channel.OIL_TEMPERATURE: "toil, oil temperature, temperature oil, oil temp",
}
"""Channel → its usual column names; upper and lower case, blanks, ``_``, ``-`` and ``.`` do not matter."""

_CHANNELS = {name.replace(" ", ""): channel for channel, text in NAMES.items() for name in text.split(", ")}


class Titled:
    """Columns with titles, or numbers from 1, and what their source states of them; `place` names it."""

    def __init__(self, place: str, titles: Sequence[str], dated: Collection[int] = ()) -> None:
        self.place, self.titles, self.dated = place, titles, dated

    def find(self, column: str) -> int:
        """Position of a column by its title, its name without the unit, or its number."""
        titles, place = self.titles, self.place
        for known in (titles, [split_title(title)[0] for title in titles]):
            positions = [position for position, title in enumerate(known) if title == column]
            if len(positions) > 1:
                numbers = " and ".join(str(position + 1) for position in positions)
                raise DataError(f"{place}: column {column!r} occurs as {numbers}; give its number")
            if positions:
                return positions[0]
        if column.isdecimal() and 1 <= int(column) <= len(titles):
            return int(column) - 1
        raise DataError(f"{place}: has no column {column!r}; it has {shown_titles(titles) or 'none'}")

    def unit(self, position: int) -> str:
        """Unit that the source states for a column; empty if it states none."""
        return split_title(self.titles[position])[1]

    def is_dated(self, position: int) -> bool:
        """Whether a column contains dates."""
        return position in self.dated

    def clocks(self, time: int | None = None) -> Mapping[int, int]:
        """Position of a column → that of its own time, if columns have more than one; the fastest one first.

        `time` is that of the record, if it is stated.
        """
        return {}


MOST_BYTES = 2**31


class FileColumns(Titled, ABC):
    """Columns of one file; `remarks` are findings."""

    remarks: tuple[Issue, ...] = ()

    def row_place(self, row: int) -> str:
        """A row, numbered from 0, for messages."""
        return f"sample {row + 1}"

    def date_by(self, position: int, form: str, date: int | None) -> None:
        """Read dates of a column in a stated format, after those of the column `date`."""
        raise DataError(f"{self.place}: a format of dates, and dates of two columns, are for texts alone")

    def load(self, positions: Sequence[int]) -> None:
        """Prepare to return columns, if reading them together is faster."""

    @abstractmethod
    def numbers(self, position: int) -> Array:
        """Values of a column, shape (n_row,), NaN where missing; `DataError` if it is not numeric."""

    def instants(self, position: int) -> tuple[Array, float]:
        """Values of a time column, shape (n_row,), and NaN; of dates, the time since the first one [s].

        With dates comes the first one since 1970, in UTC or in an unknown zone [s].
        """
        return self.numbers(position), math.nan


class RejectionError(Exception):
    """No record can be formed; it is listed with the reason, and the other records continue."""

    def __init__(self, kind: str, text: str) -> None:
        self.remark = Issue(text, kind=kind, is_unusable=True)
        super().__init__(text)


@contextmanager
def damage_named(what: str) -> Iterator[None]:
    """Turn whatever a library raises on a broken file into `RejectionError`."""
    try:
        yield
    except (DataError, RejectionError):
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise RejectionError("damaged", f"cannot be read as {what}: {reason}") from None


@dataclass(frozen=True)
class ReadColumn:
    """A column that is used, at a position among the titles, with its gain, offset and sign.

    The unit is that after the gain, empty for dates; the factor leads to SI: one for counts, None for dates.
    """

    position: int
    title: str
    config: ChannelConfig
    unit: str
    factor: Fraction | None

    def in_si(self, values: Array) -> Array:
        """Numbers in SI; unchanged if the unit is counts."""
        if self.factor is None:
            raise DataError(f"{self.title[:60]!r}: has no unit; write it like 'time [s]'")
        with np.errstate(over="ignore"):
            config = self.config
            values = values if config.gain is None else config.gain * values
            values = values + config.offset if config.offset else values
            values = scaled(-values if config.sign < 0 else values, self.factor)
            return values + zero if (zero := zero_of(self.unit)) else values


def columns_of(
    table: Titled, configured: Mapping[Channel, ChannelConfig], needed: Collection[Channel] = ()
) -> dict[Channel, ReadColumn]:
    """The columns of channels, as configured, or else by their names and units.

    A channel under its full name, such as ``chamber_1_pressure``, is in SI if no unit is stated. A column of
    a `needed` channel is refused, not ignored, if its unit has another dimension.
    """
    titles, place = table.titles, table.place
    if configured:
        indices = {channel: table.find(own.column) for channel, own in configured.items()}
    else:
        indices = channels_named(table)
        configured = {channel: ChannelConfig(column=titles[n]) for channel, n in indices.items()}
        for position, title in enumerate(titles):
            channel = channel_named(title, "")
            if channel is not None and channel in needed and channel not in indices:
                factor_to_si(table.unit(position), channel.unit, f"{place}: column {title[:60]!r}")
    if not indices:
        raise DataError(f"{place}: no column is named like a channel; found {shown_titles(titles)[:200]}")
    return {
        channel: column_at(table, n, configured[channel], channel.unit, table.unit(n))
        for channel, n in indices.items()
    }


def channels_named(table: Titled) -> dict[Channel, int]:
    """Channel → position of the column that is named like it."""
    positions: dict[Channel, int] = {}
    for position, title in enumerate(table.titles):
        channel = channel_named(title, table.unit(position)) if _CHANNELS.get(short_name(title)) else None
        if channel in positions:
            both = f"{table.titles[positions[channel]]!r} and {title!r}"
            raise DataError(f"{table.place}: more than one column is named like {channel}: {both}")
        if channel is not None:
            positions[channel] = position
    return positions


def column_at(table: Titled, position: int, config: ChannelConfig, si_unit: str, header: str) -> ReadColumn:
    """A column in a unit of the dimension of `si_unit`; `header` is the unit that the source states."""
    title = table.titles[position]
    where = f"{table.place}: column {title[:60]!r}"
    unit = _agreed_unit(config, header or ("" if config.unit else unit_by_name(title)), where)
    return ReadColumn(position, title, config, unit, factor_to_si(unit, si_unit, where))


def channel_named(title: str, unit: str, more: Mapping[str, Channel] = {}) -> Channel | None:
    """The channel that a title means, by the usual or by `more` names; None if there is none, or the unit has
    another dimension."""
    name = short_name(title)
    channel = _CHANNELS.get(name) or more.get(name)
    if channel is None or is_counts(unit) or (known := known_unit(unit)) is None:
        return channel
    return channel if known.exponents == parse_unit(channel.unit).exponents else None


def channel_called(name: str) -> Channel:
    """The channel of a name or symbol."""
    channel = channel_named(name, "")
    if channel is None:
        known = [*(each.symbol for each in Channel), *(each.value for each in Channel)]
        raise ConfigError(f"unknown channel {name!r}{nearest(name, known) or listed(known[: len(Channel)])}")
    return channel


def column_name(titles: Sequence[str], position: int) -> str:
    """How a description names a column: by its name or its title if no other has the same, or its number.

    The name comes first, because other files may have the column in another unit.
    """
    for known in ([split_title(title)[0] for title in titles], titles):
        if known[position] and known.count(known[position]) == 1:
            return known[position]
    return str(position + 1)


def split_title(title: str) -> tuple[str, str]:
    """Name and unit of a header such as ``P1 [bar]``; an empty unit if it has none.

    A unit may stand behind ``in``, or ``_`` or ``/`` as in ``P1_bar`` if the name is that of a channel or the
    time.
    """
    if len(title) > _LONGEST_TITLE:
        return title.strip(), ""
    match = _TITLE.fullmatch(title)
    if match is not None and match[1] and not (match[2] or match[3] or "").isdigit():
        return match[1], (match[2] or match[3] or "").strip()
    if match := _BEHIND.fullmatch(title.strip()):
        channel, unit = _CHANNELS.get(_plain(match[1])), known_unit(match[2])
        si = channel.unit if channel else "s" if _plain(match[1]) in ("time", "t") else ""
        if si and unit and unit.exponents == parse_unit(si).exponents:
            return match[1], match[2]
    match = _IN.fullmatch(title.strip())
    return (match[1], match[2]) if match and known_unit(match[2]) else (title.strip(), "")


def shortened(title: str, most: int = 60) -> str:
    """A header as a message quotes it."""
    return title if len(title) <= most else f"{title[: most - 1]}…"


def shown_titles(titles: Sequence[str]) -> str:
    """Some headers for a message."""
    return ", ".join(map(shortened, titles[:_MOST_SHOWN])) + ", …" * (len(titles) > _MOST_SHOWN)


def short_name(title: str) -> str:
    """A title without unit, blanks and punctuation, in lower case; of a path of TDMS its last part."""
    name = split_title(title)[0]
    return _plain(name.rpartition("'/'")[2].strip("'") if name.startswith("/'") else name)


def _plain(name: str) -> str:
    return re.sub(r"[\s_.\-]+", "", name).lower()


def is_unit(text: str) -> bool:
    """Whether a text is a unit, or the dash of a column without one."""
    return text == "-" or is_counts(text) or known_unit(text) is not None


def unit_by_name(column: str) -> str:
    """SI unit of a column under a channel's full name, or ``time``; empty for other names.

    Such columns are in SI if neither file nor description states a unit.
    """
    return _SI_BY_NAME.get(column, "")


def _agreed_unit(config: ChannelConfig, header: str, where: str) -> str:
    """Unit of a column after gain and offset, from its configuration and the unit that the source states."""
    readings = _readings(config.unit, header)
    if config.unit and (config.gain is not None or not readings or _meaning(config.unit) in readings):
        return config.unit
    if config.unit:
        raise DataError(
            f"{where}: the file says {header}, the description says {config.unit};"
            " leave 'unit' out, or give the 'gain' between them"
        )
    if not header:
        raise DataError(
            f"{where}: has no unit; name it like 'P1 [bar]', or write 'unit: bar' or 'unit: counts'"
        )
    if config.gain is not None and not is_counts(header):
        raise DataError(f"{where}: a gain needs a unit; write the 'unit' after the gain")
    return header


def unknown_header_unit(config: ChannelConfig, header: str) -> tuple[Issue, ...]:
    """A remark if the header's unit is not known, so that only the description states the scale."""
    is_checked = not header or " " in header or len(_readings(config.unit, header)) == 1
    if is_checked or not config.unit or config.gain is not None:
        return ()
    text = f"column {config.column!r}: the header says {header!r}, the description {config.unit!r}"
    return (Issue(text, kind="unknown_unit"),)


def factor_to_si(unit: str, si_unit: str, where: str) -> Fraction:
    """Factor from a unit to SI; one for counts."""
    if mistake := unit_mistake(unit, si_unit):
        raise DataError(f"{where}: {mistake}")
    return Fraction(1) if is_counts(unit) else parse_unit(unit).factor / parse_unit(si_unit).factor


def scaled(values: Array, factor: Fraction) -> Array:
    """Values times an exact factor, rounded once if numerator or denominator is one."""
    numerator, denominator = factor.numerator, factor.denominator
    if max(numerator, denominator) > _EXACT:
        return np.asarray(values * float(factor))
    product = values if numerator == 1 else values * float(numerator)
    return product if denominator == 1 else product / float(denominator)


def _meaning(unit: str) -> tuple[Unit | str | None, float]:
    return "counts" if is_counts(unit) else known_unit(unit), zero_of(unit)


def _readings(unit: str, header: str) -> set[tuple[Unit | str | None, float]]:
    """What a header's unit may mean, if it is not known: units like it, of the dimension of `unit`."""
    if is_unit(header):
        return {_meaning(header)}
    return {_meaning(like) for like in similar_units(header, unit)} if known_unit(unit) else set()
