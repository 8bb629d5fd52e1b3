"""Channels, units and sampling from the headers of a file, in the form of a description."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from textwrap import indent
from typing import Any

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_names import (
    channel_of,
    is_unit,
    known_unit,
    named_like_time,
    short_name,
    time_columns,
    times_without_unit,
    unit_by_name,
)
from hydrofdi.records.measured.description.configuration import MeasuredConfig
from hydrofdi.records.measured.description.sections import ChannelConfig, TimeConfig
from hydrofdi.records.measured.formats.opening import open_table
from hydrofdi.records.measured.formats.table import Table, shortened, split_title
from hydrofdi.records.measured.recording import counts_samples
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.units import parse_unit, similar_units

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


def refusal(file: Path, what: str, table: Table) -> DataError:
    """The error that something is missing, with a description to paste."""
    channels: dict[Channel, str] = {}
    for position in range(len(table.titles)):
        if channel := _channel(table, position):
            channels.setdefault(channel, _column(table, position, channel.unit))
    columns = channels or {Channel.CHAMBER_1_PRESSURE: "{column: '…', unit: …}"}
    form = ["format: {decimal: ','}"] if table.has_decimal_commas else []
    keys = [f"files: {file.name!r}", *form, _sampling(table), "channels:"]
    lines = [*keys, *(f"  {channel}: {column}" for channel, column in columns.items())]
    return DataError(f"{file}: {what}; describe it in a YAML file:\n" + indent("\n".join(lines), "    "))


def _sampling(table: Table) -> str:
    time = _time(table)
    if time is None or is_counter(table, time):
        return "sampling_frequency: …"
    if table.dates(time) is not None:
        return f"time: {{column: {split_title(table.titles[time])[0]!r}}}"
    return f"time: {_column(table, time, 's')}"


def _column(table: Table, position: int, si_unit: str) -> str:
    title = shortened(split_title(table.titles[position])[0])
    return f"{{column: {title!r}, unit: {_stated_unit(table, position, si_unit)}}}"


def _stated_unit(table: Table, position: int, si_unit: str) -> str:
    """The unit that a header states, in its usual spelling; a placeholder if it is not clear."""
    header = table.unit(position) or unit_by_name(table.titles[position])
    similar = similar_units(header, si_unit)
    return header if is_unit(header) else similar[0] if len(similar) == 1 else "…"


def is_counter(table: Table, position: int) -> bool:
    """Whether a column without a unit counts the samples."""
    if table.unit(position) or table.dates(position) is not None:
        return False
    try:
        return counts_samples(table.numbers(position))
    except DataError:
        return False


def _channel(table: Table, position: int) -> Channel | None:
    """The channel to suggest for a column; None if its name is unknown, or its unit does not fit."""
    title, unit = table.titles[position], known_unit(table.unit(position))
    channel = channel_of(table, position) or _CHANNELS.get(short_name(title))
    if unit is None or channel is None:
        return channel
    return channel if unit.exponents == parse_unit(channel.unit).exponents else None


def _time(table: Table) -> int | None:
    """A column that may be the time, by its name, its unit or its dates."""
    second = parse_unit("s").exponents
    units = [known_unit(table.unit(position)) for position in range(len(table.titles))]
    stated = [position for position, unit in enumerate(units) if unit and unit.exponents == second]
    return next(iter([*named_like_time(table), *times_without_unit(table), *stated]), None)


_MOST_SHOWN = 12


def completed(config: MeasuredConfig, files: Sequence[Path]) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    """A description with the channels that the first readable file states, and a remark on unused columns.

    Parameters
    ----------
    config : MeasuredConfig
        A description without channels; its sampling is kept.
    files : sequence of path
        Not empty.

    Raises
    ------
    DataError
        The headers are not sufficient, or no file can be read.
    """
    for number, file in enumerate(files, 1):
        try:
            with open_table(file, str(file), config.format) as table:
                return _completed(config, table, file)
        except RejectionError as rejection:
            if number == len(files):
                raise DataError(f"{file}: {rejection}") from None
    raise AssertionError("there are files")


def _completed(config: MeasuredConfig, table: Table, file: Path) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    names = [split_title(title)[0] for title in table.titles]

    def column(title: str) -> str:
        """The name without the unit: other files may have the same column in another unit."""
        name = split_title(title)[0]
        return name if names.count(name) == 1 else title

    channels = {
        channel: ChannelConfig(column=column(title)) for channel, title in channels_in(table, file).items()
    }
    found: dict[str, Any] = {"channels": channels}
    if config.time is None and config.sampling_frequency is None:
        sampling = sampling_in(table, file, None)
        found["time"] = TimeConfig(column=column(sampling["time"]["column"]))
    done = config.model_copy(update=found)
    times = _titles(table, time_columns(table)) if done.time is None else [done.time.column]
    return done, unused_in(table, [*times, *(each.column for each in channels.values())])


def channels_in(table: Table, file: Path) -> dict[Channel, str]:
    """Channel → title of its column.

    Raises
    ------
    DataError
        The headers are not sufficient; the message shows the description to write.
    """
    if not table.titles:
        raise DataError(f"{file}: contains no columns")
    channels: dict[Channel, str] = {}
    for position, title in enumerate(table.titles):
        channel = channel_of(table, position)
        if channel is None:
            continue
        if channel in channels:
            raise refusal(file, f"more than one column is named like {channel}", table)
        if not (table.unit(position) or unit_by_name(title)):
            raise refusal(file, f"column {shortened(title)!r} has no unit", table)
        channels[channel] = title
    if not channels:
        raise refusal(file, f"no column is named like a channel; found {_first(table.titles)}", table)
    return channels


def sampling_in(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, Any]:
    """``time`` or ``sampling_frequency`` of a description.

    Raises
    ------
    DataError
        The headers are not sufficient; the message shows the description to write.
    """
    times = _titles(table, time_columns(table))
    if sampling_frequency is not None and len(times) == 1:
        raise DataError(f"{file}: has a column {times[0]!r}; leave the sampling frequency out")
    if sampling_frequency is not None and not times:
        return {"sampling_frequency": sampling_frequency}
    times = times or _titles(table, times_without_unit(table))
    if len(times) > 1:
        raise refusal(file, f"has more than one column of time: {_first(times)}", table)
    if not times:
        raise refusal(
            file,
            "no sampling frequency is given (sampling_frequency=1kHz), and no column is named 'time [s]'",
            table,
        )
    if is_counter(table, table.find(times[0])):
        raise refusal(file, f"column {times[0]!r} counts the samples and is not a time", table)
    return {"time": {"column": times[0]}}


def _titles(table: Table, positions: Sequence[int]) -> list[str]:
    return [table.titles[position] for position in positions]


def unused_in(table: Table, used: Collection[str]) -> tuple[Issue, ...]:
    """A remark that names the unused columns."""
    positions = {table.find(column) for column in used}
    left = [title for position, title in enumerate(table.titles) if position not in positions]
    return (Issue(f"columns not used: {_first(left)}", kind="unused"),) if left else ()


def _first(titles: Sequence[str]) -> str:
    return ", ".join(map(shortened, titles[:_MOST_SHOWN])) + (", …" if len(titles) > _MOST_SHOWN else "")
