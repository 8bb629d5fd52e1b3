"""A suggested description for a plain file, from its headers."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

from hydrofdi.errors import DataError
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_names import channel_of, named_like_time, short_name, times_without_unit
from hydrofdi.records.measured.column_units import is_unit, known_unit, unit_by_name
from hydrofdi.records.measured.formats.table import Table, shortened, split_title
from hydrofdi.records.measured.sampling import counts_samples
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
