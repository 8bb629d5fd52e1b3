"""Columns of a stream: their channels, and their conversion to SI."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Array
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_names import (
    agreed_unit,
    calibrated,
    channel_named,
    factor_to_si,
    is_counts,
    scaled,
    titles_of_dates,
    titles_of_time,
    unit_by_name,
)
from hydrofdi.records.measured.description.sections import ChannelConfig, TimeConfig
from hydrofdi.records.measured.formats.table import find_column, shortened, split_title

Channels = Mapping[Channel, ChannelConfig]
"""Channel → column, as in descriptions of measured files. Empty if names and units are self-explanatory."""

_USUAL = {"Pa": "bar", "m": "mm", "m/s": "mm/s", "V": "V"}


@dataclass(frozen=True)
class Column:
    """One column of a stream.

    Attributes
    ----------
    position : int
                Position among the titles.
    title : str
    config : ChannelConfig
        Gain, offset and sign.
    factor : Fraction or None
                Factor from its unit to SI; None for a column of dates without a unit.
    """

    position: int
    title: str
    config: ChannelConfig
    factor: Fraction | None

    def in_si(self, values: Array) -> Array:
        """Values in SI, as from a file with this column.

        Raises
        ------
        DataError
            They are numbers in a column of dates without a unit.
        """
        if self.factor is None:
            raise _no_unit_of_time(repr(self.title[:60]))
        with np.errstate(over="ignore"):
            return scaled(calibrated(values, self.config), self.factor)


@dataclass(frozen=True)
class Columns:
    """The columns of a stream that are used.

    Attributes
    ----------
    time : Column or None
        None if there is no time column.
    channels : dict of Channel to Column
    """

    time: Column | None
    channels: dict[Channel, Column]


def columns_of(
    titles: Sequence[str],
    place: str,
    configured: Channels | None = None,
    time: TimeConfig | None = None,
    units: Sequence[str] | None = None,
    needed: Collection[Channel] = (),
    dated: Collection[int] = (),
) -> Columns:
    """The columns that titles mean, by the configuration, or else by the names and units of plain files.

    A channel under its full name, such as ``chamber_1_pressure``, and ``time`` are in SI if no unit is
    stated.

    Parameters
    ----------
    titles : sequence of str
        Such as ``P1 [bar]``.
    place : str
        The stream, for messages.
    configured : mapping of Channel to ChannelConfig, optional
    time : TimeConfig, optional
    units : sequence of str, optional
        Units from a separate row.
    needed : collection of Channel
        Channels whose columns are refused, not ignored, if their unit has another dimension.
    dated : collection of int
        Positions of columns that contain dates, which need no unit.

    Raises
    ------
    DataError
        No title is a channel, two titles are the same one, or a unit is missing, unknown or of another
        dimension.
    """
    stated = [split_title(title)[1] for title in titles]
    if units is not None:
        stated = [own or header for own, header in zip(units, stated, strict=True)]
    channels = _configured(titles, stated, configured or {}, place)
    if not channels:
        channels = _named(titles, stated, place)
        _refuse_other_dimensions(titles, stated, {*needed} - {*channels}, place)
    if not channels:
        shown = ", ".join(map(shortened, titles[:12]))
        hint = _encoding_hint() if "\ufffd" in shown else ""
        raise DataError(f"{place}: no column is named like a channel; found {shown[:200]!r}{hint}")
    return Columns(_time(titles, stated, time, place, dated), channels)


def _configured(
    titles: Sequence[str], units: Sequence[str], configured: Channels, place: str
) -> dict[Channel, Column]:
    return {
        channel: _column(channel, find_column(titles, config.column, place), titles, units, config, place)
        for channel, config in configured.items()
    }


def _named(titles: Sequence[str], units: Sequence[str], place: str) -> dict[Channel, Column]:
    found: dict[Channel, Column] = {}
    for position, title in enumerate(titles):
        channel = channel_named(title, units[position])
        if channel in found:
            raise DataError(f"{place}: both {found[channel].title!r} and {title!r} are named like {channel}")
        if channel is not None:
            config = ChannelConfig(column=title)
            found[channel] = _column(channel, position, titles, units, config, place)
    return found


def _refuse_other_dimensions(
    titles: Sequence[str], units: Sequence[str], missing: Collection[Channel], place: str
) -> None:
    for title, unit in zip(titles, units, strict=True):
        channel = channel_named(title, "")
        if channel is not None and channel in missing:
            factor_to_si(unit, channel.unit, f"{place}: {title[:60]!r}")


def _column(
    channel: Channel,
    position: int,
    titles: Sequence[str],
    units: Sequence[str],
    config: ChannelConfig,
    place: str,
) -> Column:
    title = titles[position]
    where = f"{place}: {title[:60]!r}"
    header = units[position] or ("" if config.unit else unit_by_name(title))
    if not (header or config.unit):
        raise DataError(f"{where}: has no unit; write it like '{channel.symbol} [{_USUAL[channel.unit]}]'")
    unit = agreed_unit(config, header, where)
    if is_counts(unit) and not config.unit:
        raise DataError(f"{where}: is in counts; write 'gain' and 'unit' of {channel} in the configuration")
    return Column(position, title, config, factor_to_si(unit, channel.unit, where))


def _time(
    titles: Sequence[str],
    units: Sequence[str],
    config: TimeConfig | None,
    place: str,
    dated: Collection[int],
) -> Column | None:
    if config is not None:
        found = [find_column(titles, config.column, place)]
    elif len(found := _named_time(titles, units, dated)) > 1:
        raise DataError(f"{place}: has more than one time column: {', '.join(titles[n] for n in found)}")
    if not found:
        return None
    title, header = titles[found[0]], units[found[0]]
    where = f"{place}: {title[:60]!r}"
    stated = ChannelConfig(column=title, unit=config.unit if config else "")
    is_dated = found[0] in dated
    header = header.strip("-") if is_dated else header
    if not (stated.unit or header or unit_by_name(title)):
        if is_dated:
            return Column(found[0], title, ChannelConfig(column=title), None)
        raise _no_unit_of_time(where)
    unit = agreed_unit(stated, header, where)
    return Column(found[0], title, ChannelConfig(column=title), factor_to_si(unit, "s", where))


def _named_time(titles: Sequence[str], units: Sequence[str], dated: Collection[int]) -> list[int]:
    """Columns with a name of time: numbers with a unit are preferred to dates."""
    named = titles_of_time(titles, units)
    usable = [n for n in named if n in dated or units[n] or unit_by_name(titles[n])]
    return usable or titles_of_dates(titles, dated) or named


def _encoding_hint() -> str:
    return "; this is not UTF-8: write, in the file of config, 'format: {encoding: cp1252}'"


def _no_unit_of_time(where: str) -> DataError:
    return DataError(f"{where}: has no unit; write it like 'time [s]'")
