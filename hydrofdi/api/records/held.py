"""Columns in memory as a source of records: which of them are channels, in which units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hydrofdi.api.arguments import refusal
from hydrofdi.api.records.columns import Column, Held
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.records import Channel
from hydrofdi.records.measured.column_names import channel_named
from hydrofdi.records.measured.column_units import is_counts, known_unit, unit_by_name
from hydrofdi.records.measured.formats.table import split_title
from hydrofdi.records.measured.held import HeldSource, HeldTable, held_source
from hydrofdi.records.measured.sampling import counts_samples
from hydrofdi.settings.counting import counted
from hydrofdi.settings.messages import listed, nearest
from hydrofdi.units import parse_unit, similar_units

Names = str | Mapping[str, str] | None
"""One name for all columns, or column → name."""


def records_of(data: Held, frequency: float | None, channel: Names, unit: Names) -> HeldSource:
    """Records of columns.

    Parameters
    ----------
    data : Held
    frequency : float or None
        [Hz]
    channel, unit : str or mapping, optional
        As in `hydrofdi.measure`.

    Raises
    ------
    ConfigError, DataError
        Names or units are missing, or contradict each other.
    """
    if frequency is not None and data.time is not None and counts_samples(data.time.values):
        data = replace(data, time=None)
    chosen = _chosen(data, channel)
    described = {found: _described(data, found, column, unit) for found, column in chosen.items()}
    titles = [found.value for found in chosen]
    units = [column.unit or "" for column in chosen.values()]
    values = [column.values for column in chosen.values()]
    sampling = _sampling(data, frequency, unit)
    if data.time is not None:
        titles, units, values = [*titles, "time"], [*units, ""], [*values, data.time.values]
    n_record = max((len(array) for array in values if array.ndim > 1), default=1)
    if n_record == 0:
        raise DataError(f"{data.kind}: contains no records")
    named = (data.record_ids or [*map(str, range(n_record))], data.groups, data.labels)
    record_ids, groups, labels = (texts or [""] * n_record for texts in named)
    tables = [
        HeldTable(data.kind, titles, units, [_row(data, array, row, n_record) for array in values], *names)
        for row, names in enumerate(zip(record_ids, groups, labels, strict=True))
    ]
    return held_source(tables, described, sampling)


def _described(data: Held, channel: Channel, column: Column, unit: Names) -> dict[str, str]:
    """What a description of measured files says of a column."""
    given = unit
    if not isinstance(unit, str | Mapping | None):
        raise refusal("unit", "a unit, or column → unit", unit)
    if isinstance(unit, Mapping):
        names = (
            name for name in unit if name in (column.title, column.name) or channel_named(name, "") == channel
        )
        given = next((unit[name] for name in names), None)
    if given is None and not (column.unit is None or column.unit or unit_by_name(column.name)):
        raise _no_unit(data, column.name or channel.value, "bar" if channel.is_pressure else channel.unit)
    given = channel.unit if given is None and not column.unit else given
    _require_fitting(data, channel, column, given)
    return {"column": channel.value} | ({} if given is None else {"unit": str(given)})


def _require_fitting(data: Held, channel: Channel, column: Column, given: object) -> None:
    """Check the unit of a column that is in memory."""
    unit = str(given or column.unit)
    found = known_unit(unit)
    if is_counts(unit) or (found is not None and found.exponents == parse_unit(channel.unit).exponents):
        return
    place = "unit" if given else f"{data.kind}: column {column.name or channel.value!r}"
    if found is not None:
        raise DataError(f"{place}: {unit} is not convertible to {channel.unit}")
    similar = similar_units(unit, channel.unit)
    hint = f"did you mean {' or '.join(map(repr, similar))}?" if similar else f"use one like {channel.unit!r}"
    raise DataError(f"{place}: unknown unit {unit!r}; {hint}")


def _no_unit(data: Held, name: str, unit: str) -> DataError:
    return DataError(
        f"{data.kind}: {name!r} has no unit; name it '{name} [{unit}]', set its attribute units='{unit}', or"
        f" give unit='{unit}'"
    )


def _row(data: Held, values: np.ndarray[Any, np.dtype[np.float64]], row: int, n_record: int) -> Any:
    """The samples of a record; a column of one dimension is shared by all records."""
    if values.ndim == 1:
        return values
    if len(values) != n_record:
        raise DataError(
            f"{data.kind}: has {counted(len(values), 'record')} of one channel and {n_record} of another"
        )
    return values[row]


def _sampling(data: Held, frequency: float | None, unit: Names) -> dict[str, Any]:
    if frequency is not None and data.time is not None:
        raise DataError(f"{data.kind}: has a column {data.time.name!r}; leave the sampling frequency out")
    if frequency is not None:
        return {"sampling_frequency": frequency}
    if data.time is None:
        raise DataError(
            f"{data.kind}: no sampling frequency is given (sampling_frequency='1 kHz'), and nothing is named"
            " 'time'"
        )
    stated = unit.get(data.time.name) if isinstance(unit, Mapping) else None
    stated = stated or data.time.unit or unit_by_name(data.time.name)
    if stated == "":
        raise DataError(
            f"{data.kind}: {data.time.name!r} has no unit; name it '{data.time.name} [s]', set its attribute"
            f" units='s', or give unit={{{data.time.name!r}: 's'}}"
        )
    return {"time": {"column": "time", "unit": stated or "s"}}


def _chosen(data: Held, channel: Names) -> dict[Channel, Column]:
    """The columns that are channels: those that are said to be, or are named like one."""
    if isinstance(channel, Mapping):
        by_title = {column.title: column for column in data.columns}
        named = {column.name: column for column in data.columns} | by_title
        if unknown := [name for name in channel if name not in named]:
            raise DataError(f"{data.kind}: has no column {unknown[0]!r}{listed([*by_title])}")
        return {_channel(name): named[column] for column, name in channel.items()}
    wanted = None if channel is None else _channel(channel)
    if len(data.columns) == 1 and (wanted or not data.columns[0].name):
        return {wanted or Channel.CHAMBER_1_PRESSURE: data.columns[0]}
    chosen: dict[Channel, Column] = {}
    for column in data.columns:
        found = channel_named(column.name, column.unit or "")
        if found in chosen:
            raise DataError(f"{data.kind}: more than one column is named like {found}")
        if found is not None and wanted in (None, found):
            chosen[found] = column
    if not chosen:
        raise _no_channel(data, wanted)
    return chosen


def _no_channel(data: Held, wanted: Channel | None) -> DataError:
    """The error for columns none of which is a channel."""
    for column in data.columns:
        meant = channel_named(column.name, "")
        if meant is not None and wanted in (None, meant):
            unit = f"the unit {column.unit!r}, which is not convertible to {meant.unit}"
            return DataError(f"{data.kind}: {column.name!r} has {unit}")
    for title in data.texts:
        meant = channel_named(split_title(title)[0], "")
        if meant is not None and wanted in (None, meant):
            remedy = "convert it to numbers, for example with pandas.to_numeric"
            return DataError(f"{data.kind}: column {title!r} contains text; {remedy}")
    names = ", ".join(repr(column.name) for column in data.columns) or "no column of numbers"
    return DataError(
        f"{data.kind}: no column is named like {wanted or 'a channel'}; found {names};"
        " give channel={'column': 'P1'}"
    )


def _channel(name: str) -> Channel:
    if not isinstance(name, str):
        raise refusal("channel", "the name of a channel, or column → name", name)
    found = channel_named(name, "")
    if found is None:
        raise ConfigError(f"channel: {name!r} is unknown{nearest(name, [each.value for each in Channel])}")
    return found
