"""Records of objects in memory: arrays, mappings, data frames, datasets."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError
from hydrofdi.records import Channel
from hydrofdi.records.columns import channel_called, channel_named, channels_named, split_title
from hydrofdi.records.source import HeldSource, MemoryTable, held_source
from hydrofdi.records.times import are_times, counts_samples, instants_of, named_time
from hydrofdi.settings.arguments import Names, refusal
from hydrofdi.settings.messages import counted

_CF_POWER = re.compile(r"(?<=[A-Za-z])(-?\d)")
"""A power as CF writes it: ``m s-1``."""


Part = tuple[str, Any, str | None]
"""Title of a column as it is written, such as ``P1 [bar]``; its values, of shape (n_time,) or (n_record,
n_time); its unit, empty if it is not stated, and None if there is no place to state it."""


def held(data: Any, number: int | None = None) -> MemoryTable:
    """What an object in memory holds."""

    def kind(noun: str) -> str:
        return f"the {noun}" if number is None else f"{noun} {number}"

    xarray, pandas = sys.modules.get("xarray"), sys.modules.get("pandas")
    if xarray is not None and isinstance(data, xarray.DataArray):
        return _of_dataset(kind("DataArray"), {str(data.name or ""): data})
    if xarray is not None and isinstance(data, xarray.Dataset):
        return _of_dataset(kind("Dataset"), {str(name): each for name, each in data.data_vars.items()})
    if pandas is not None and isinstance(data, pandas.Series):
        return _of_frame(kind("DataFrame"), data.to_frame())
    if hasattr(data, "to_pandas") or (pandas is not None and isinstance(data, pandas.DataFrame)):
        return _of_frame(kind("DataFrame"), data.to_pandas() if hasattr(data, "to_pandas") else data)
    if isinstance(data, Mapping):
        return _timed(kind("mapping"), [(str(title), values, None) for title, values in data.items()])
    return _table(kind("array"), [("", data, None)])


def _of_frame(kind: str, frame: Any) -> MemoryTable:
    parts = [(str(title), _values(frame.iloc[:, n])) for n, title in enumerate(frame.columns)]
    parts = [(title, values) for title, values in parts if values.dtype.kind in "fiu" or are_times(values)]
    if frame.index.name is not None or frame.index.dtype.kind in "mM":
        parts.append((str(frame.index.name or "time"), _values(frame.index)))
    return _timed(kind, [(title, values, "") for title, values in parts])


def _values(series: Any) -> NDArray[Any]:
    """Values of a column or an index; dates with a zone in UTC."""
    values: NDArray[Any] = series.to_numpy("datetime64[ns]" if series.dtype.kind == "M" else None)
    return values


def _of_dataset(kind: str, variables: Mapping[str, Any]) -> MemoryTable:
    dims = {
        name: "time" if "time" in each.dims else (each.dims or ("",))[-1] for name, each in variables.items()
    }
    along = "time" if "time" in dims.values() else next(iter(dims.values()), "")
    chosen = {name: each for name, each in variables.items() if along in each.dims}
    parts = [
        (name, each.transpose(..., along).to_numpy(), _usual(str(each.attrs.get("units", ""))))
        for name, each in chosen.items()
    ]
    leading = next((each for each in chosen.values() if each.ndim > 1), None)
    names = {} if leading is None else _names(leading, along)
    times = next((each.coords[along] for each in chosen.values() if along in each.coords), None)
    if times is None:
        return replace(_table(kind, parts), **names)
    parts.append((along, times.to_numpy(), _usual(str(times.attrs.get("units", "")))))
    return replace(_table(kind, parts), time=len(parts) - 1, **names)


def _names(data: Any, along: str) -> dict[str, Any]:
    """Names, groups and labels of the records of an array, from its coordinates."""
    (over, *_) = (dim for dim in data.dims if dim != along)
    coordinates = {"record_ids": over, "groups": "group", "labels": "label"}
    held = {name: data.coords[each] for name, each in coordinates.items() if each in data.coords}
    along_records = {name: each for name, each in held.items() if each.dims == (over,)}
    return {name: [known_text(text) for text in each.to_numpy()] for name, each in along_records.items()}


def known_text(given: Any) -> str:
    """What is known of a record, such as its label; empty if it is missing (None, NaN)."""
    is_missing = given is None or given is np.ma.masked or bool(np.ndim(given) == 0 and given != given)
    return "" if is_missing or str(given) == "<NA>" else str(given)


def _timed(kind: str, parts: Sequence[Part]) -> MemoryTable:
    """A table in which the column of time is found by its name."""
    table = _table(kind, parts)
    places = named_time(table)
    if len(places) > 1:
        raise DataError(f"{kind}: has more than one column of time")
    return replace(table, time=places[0]) if places else table


def _table(kind: str, parts: Sequence[Part]) -> MemoryTable:
    """Numbers of columns; a unit in a title comes first."""
    columns, units, dates = list[NDArray[np.float64]](), list[str | None](), dict[int, float]()
    for position, (title, values, unit) in enumerate(parts):
        array = _samples(values)
        if are_times(array):
            try:
                (array, dates[position]), unit = instants_of(array), "s"
            except ValueError as error:
                raise DataError(f"{kind}: column {title!r}: {error}") from None
        elif array.dtype.kind not in "fiu":
            raise DataError(
                f"{kind}: {f'column {title!r} ' if title else ''}contains something other than real numbers"
            )
        else:
            unit = split_title(title)[1] or unit
        if array.ndim not in (1, 2):
            raise DataError(
                f"{kind}: has {counted(array.ndim, 'dimension')}; give samples, or records × samples"
            )
        if array.ndim == 2 and array.shape[1] == 1 < array.shape[0]:
            raise DataError(
                f"{kind}: shape {array.shape} is {counted(array.shape[0], 'record')}"
                " of 1 sample; transpose it or ravel it"
            )
        columns.append(array.astype(np.float64))
        units.append(unit)
    return MemoryTable(kind, [title for title, _, _ in parts], units, columns, dates)


def _samples(values: Any) -> NDArray[Any]:
    """Values as an array; masked ones are missing (NaN)."""
    parts = values if isinstance(values, list | tuple) else [values]
    if not any(isinstance(each, np.ma.MaskedArray) for each in parts):
        return np.asarray(values)
    masked: Any = np.ma.asarray(values)
    masked = masked.astype(np.float64) if masked.dtype.kind in "iu" else masked
    missing: Any = np.array("NaT", masked.dtype) if masked.dtype.kind in "mM" else np.nan
    array: NDArray[Any] = np.ma.filled(masked, missing) if masked.dtype.kind in "fmM" else masked.data
    return array


def _usual(unit: str) -> str:
    """A unit in the style of CF, such as ``m s-1``, as hydrofdi reads it."""
    return _CF_POWER.sub(r"^\1", unit)


def records_of(table: MemoryTable, frequency: float | None, channel: Names, unit: Names) -> HeldSource:
    """Records of columns."""
    if not isinstance(unit, str | Mapping | None):
        raise refusal("unit", "a unit, or column → unit", unit)
    kind, time = table.place, table.time
    if frequency is not None and time is not None:
        if not counts_samples(table.columns[time]):
            name = split_title(table.titles[time])[0]
            raise DataError(f"{kind}: has a column {name!r}; leave the sampling frequency out")
        time = None
    if frequency is None and time is None:
        raise DataError(
            f"{kind}: no sampling frequency is given (sampling_frequency='1 kHz'), and nothing is named"
            " 'time'"
        )
    chosen, titles = _chosen(table, channel), table.titles
    names = [title if title and titles.count(title) == 1 else str(n) for n, title in enumerate(titles, 1)]
    units = {found: found.unit if table.units[n] is None else "" for found, n in chosen.items()}
    described: dict[str, Any] = {"sampling_frequency": frequency}
    described["channels"] = {
        found.value: {"column": names[n], "unit": _given(unit, found, titles[n]) or units[found]}
        for found, n in chosen.items()
    }
    used = [*chosen.values()]
    if time is not None:
        stated = unit.get(split_title(titles[time])[0], "") if isinstance(unit, Mapping) else ""
        described["time"], used = {"column": names[time], "unit": stated}, [*used, time]
    lengths = {len(table.columns[n]) for n in used if table.columns[n].ndim > 1} or {1}
    n_record = max(lengths)
    if n_record == 0:
        raise DataError(f"{kind}: contains no records")
    if len(lengths) > 1:
        raise DataError(f"{kind}: has {min(lengths)} records of one channel and {n_record} of another")
    unknown = [""] * n_record
    table = replace(
        table,
        record_ids=table.record_ids or [*map(str, range(n_record))],
        groups=table.groups or unknown,
        labels=table.labels or unknown,
    )
    return held_source(table, described)


def _given(unit: Names, channel: Channel, title: str) -> str:
    """The unit that is said of a column; empty if none is."""
    if not isinstance(unit, Mapping):
        return unit or ""
    own = (title, split_title(title)[0])
    return next((unit[name] for name in unit if name in own or channel_named(name, "") == channel), "")


def _chosen(table: MemoryTable, channel: Names) -> dict[Channel, int]:
    """Positions of the columns that are channels: those that are said to be, or are named like one."""
    if isinstance(channel, Mapping):
        return {_channel(name): table.find(str(column)) for column, name in channel.items()}
    wanted = None if channel is None else _channel(channel)
    titles = {n: title for n, title in enumerate(table.titles) if n != table.time}
    if len(titles) == 1 and (wanted or not next(iter(titles.values()))):
        return {wanted or Channel.CHAMBER_1_PRESSURE: next(iter(titles))}
    named = channels_named(table)
    chosen = {found: n for found, n in named.items() if n in titles and wanted in (None, found)}
    if not chosen:
        listing = ", ".join(map(repr, titles.values())) or "no column of numbers"
        raise DataError(
            f"{table.place}: no column is named like {wanted or 'a channel'}; found {listing};"
            " give channel={'column': 'P1'}"
        )
    return chosen


def _channel(name: str) -> Channel:
    if not isinstance(name, str):
        raise refusal("channel", "the name of a channel, or column → name", name)
    return channel_called(name)
