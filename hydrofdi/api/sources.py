"""Whatever holds records, as a source of them: paths, arrays, data frames, datasets."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from os import PathLike
from typing import Any

import numpy as np

from hydrofdi.api.columns import Column, Held, held
from hydrofdi.api.places import path_of
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.pipeline.sources import open_source
from hydrofdi.records import Channel, RecordSource
from hydrofdi.records.measured.column_names import channel_named
from hydrofdi.records.measured.held import HeldTable, held_source
from hydrofdi.settings.mistakes import nearest
from hydrofdi.units import parse_quantity

Names = str | Mapping[str, str] | None
"""One name for all columns, or column → name."""


def sources_of(
    data: Any,
    channels: Collection[Channel],
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
) -> list[RecordSource]:
    """The records in files or in memory.

    Parameters
    ----------
    data : path, sequence of path, array_like, mapping, pandas.DataFrame, xarray.DataArray or xarray.Dataset
    channels : collection of Channel
        What is needed of simulated records.
    sampling_frequency : str or float, optional
        [Hz]
    channel, unit : str or mapping, optional
        Of arrays, as `hydrofdi.measure` has them.

    Raises
    ------
    ConfigError, DataError, StoreError
        They cannot be read, or do not say enough.
    """
    frequency = frequency_of(sampling_frequency)
    paths = _paths(data)
    if paths is None:
        return [_held_source(held(data), frequency, channel, unit)]
    if channel is not None or unit is not None:
        raise ConfigError("channel and unit are for arrays; files are described by a YAML (docs/measured.md)")
    return [open_source(path_of(path), channels, frequency) for path in paths]


def frequency_of(given: str | float | None) -> float | None:
    """A sampling frequency [Hz].

    Raises
    ------
    ConfigError
        It is none above zero.
    """
    if given is None:
        return None
    try:
        value = parse_quantity(given, "Hz") if isinstance(given, str) else float(given)
    except ValueError as error:
        raise ConfigError(f"sampling_frequency: {error}") from None
    if not 0.0 < value < float("inf"):
        raise ConfigError(f"sampling_frequency: must be above zero; found {given!r}")
    return value


def _paths(data: Any) -> list[str | PathLike[str]] | None:
    """The paths that data are; None where they are something else."""
    if isinstance(data, str | PathLike):
        return [data]
    is_paths = (
        isinstance(data, list | tuple) and data and all(isinstance(each, str | PathLike) for each in data)
    )
    return list(data) if is_paths else None


def _held_source(data: Held, frequency: float | None, channel: Names, unit: Names) -> RecordSource:
    chosen = _chosen(data, channel)
    described = {found: _described(data, found, column, unit) for found, column in chosen.items()}
    titles = [found.value for found in chosen]
    units = [column.unit or "" for column in chosen.values()]
    values = [column.values for column in chosen.values()]
    sampling = _sampling(data, frequency)
    if data.time is not None:
        titles, units, values = [*titles, "time"], [*units, ""], [*values, data.time.values]
    n_record = max((len(array) for array in values if array.ndim > 1), default=1)
    if n_record == 0:
        raise DataError(f"{data.kind}: holds no records")
    record_ids = data.record_ids or [str(row) for row in range(n_record)]
    tables = [
        HeldTable(data.kind, titles, units, [_row(data, array, row, n_record) for array in values], record_id)
        for row, record_id in enumerate(record_ids)
    ]
    return held_source(tables, described, sampling)


def _described(data: Held, channel: Channel, column: Column, unit: Names) -> dict[str, str]:
    """What a description of measured files says of a column."""
    given = unit
    if isinstance(unit, Mapping):
        names = (name for name in unit if name == column.name or channel_named(name, "") == channel)
        given = next((unit[name] for name in names), None)
    if given is None and column.unit == "":
        raise _no_unit(data, column.name or channel.value, "bar" if channel.is_pressure else channel.unit)
    given = channel.unit if given is None and column.unit is None else given
    return {"column": channel.value} | ({} if given is None else {"unit": str(given)})


def _no_unit(data: Held, name: str, unit: str) -> DataError:
    return DataError(
        f"{data.kind}: {name!r} has no unit; name it '{name} [{unit}]', set its attribute units='{unit}', or"
        f" give unit='{unit}'"
    )


def _row(data: Held, values: np.ndarray[Any, np.dtype[np.float64]], row: int, n_record: int) -> Any:
    """The samples of a record; those of one that all records share."""
    if values.ndim == 1:
        return values
    if len(values) != n_record:
        raise DataError(f"{data.kind}: has {len(values)} records of one channel and {n_record} of another")
    return values[row]


def _sampling(data: Held, frequency: float | None) -> dict[str, Any]:
    if frequency is not None and data.time is not None:
        raise DataError(f"{data.kind}: has a column {data.time.name!r}; leave the sampling frequency out")
    if frequency is not None:
        return {"sampling_frequency": frequency}
    if data.time is None:
        raise DataError(
            f"{data.kind}: no sampling frequency is given (sampling_frequency='1 kHz'), and nothing is named"
            " 'time'"
        )
    if data.time.unit == "":
        raise DataError(
            f"{data.kind}: {data.time.name!r} has no unit; name it '{data.time.name} [s]', or set its"
            " attribute units='s'"
        )
    return {"time": {"column": "time", "unit": data.time.unit or "s"}}


def _chosen(data: Held, channel: Names) -> dict[Channel, Column]:
    """The columns that are channels: those that are said to be, or are named like one."""
    if isinstance(channel, Mapping):
        named = {column.name: column for column in data.columns}
        if unknown := [name for name in channel if name not in named]:
            raise DataError(f"{data.kind}: has no column {unknown[0]!r}{nearest(unknown[0], list(named))}")
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
        names = ", ".join(repr(column.name) for column in data.columns)
        raise DataError(
            f"{data.kind}: no column is named like {wanted or 'a channel'}; found {names};"
            " give channel={'column': 'P1'}"
        )
    return chosen


def _channel(name: str) -> Channel:
    found = channel_named(name, "")
    if found is None:
        raise ConfigError(f"channel: {name!r} is unknown{nearest(name, [each.value for each in Channel])}")
    return found
