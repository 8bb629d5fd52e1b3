"""Arrays, data frames and datasets as named columns of numbers."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.arguments import Names, refusal
from hydrofdi.errors import DataError
from hydrofdi.records import Channel
from hydrofdi.records.dates import instant, is_dated
from hydrofdi.records.measured.columns import (
    channel_called,
    channel_named,
    channels_named,
    find_column,
    named_time,
    split_title,
)
from hydrofdi.records.measured.recording import counts_samples
from hydrofdi.records.measured.source import HeldSource, HeldTable, held_source
from hydrofdi.settings.messages import counted

_CF_POWER = re.compile(r"(?<=[A-Za-z])(-?\d)")
"""A power as CF writes it: ``m s-1``."""


@dataclass(frozen=True)
class Column:
    """A column of one or more records: values, shape (n_time,) or (n_record, n_time), under their title as it
    is written, such as ``P1 [bar]``. Its ``unit`` is empty if it is not stated, and None if there is no place
    to state it. Dates, or durations, count from ``since`` [s since 1970].
    """

    title: str
    values: NDArray[np.float64]
    unit: str | None
    since: float = 0.0
    is_dates: bool = False

    @property
    def name(self) -> str:
        """The title without its unit."""
        return split_title(self.title)[0]


@dataclass(frozen=True)
class Held:
    """Columns, and when they were sampled; ``kind`` is what messages call them. Names, groups and labels of
    the records are empty if there are none.
    """

    kind: str
    columns: Sequence[Column]
    time: Column | None = None
    record_ids: Sequence[str] = field(default=())
    groups: Sequence[str] = field(default=())
    labels: Sequence[str] = field(default=())


def held(data: Any, number: int | None = None) -> Held:
    """What an object in memory holds."""

    def kind(noun: str) -> str:
        return f"the {noun}" if number is None else f"{noun} {number}"

    xarray, pandas = sys.modules.get("xarray"), sys.modules.get("pandas")
    if xarray is not None and isinstance(data, xarray.DataArray):
        return _of_dataset(kind("DataArray"), {str(data.name or ""): data})
    if xarray is not None and isinstance(data, xarray.Dataset):
        return _of_dataset(kind("Dataset"), {str(name): each for name, each in data.data_vars.items()})
    if pandas is not None and isinstance(data, pandas.Series | pandas.DataFrame):
        frame = data.to_frame() if isinstance(data, pandas.Series) else data
        return _of_frame(kind("DataFrame"), frame)
    if hasattr(data, "to_pandas"):
        return _of_frame(kind("DataFrame"), data.to_pandas())
    if isinstance(data, Mapping):
        columns = [_column(kind("mapping"), str(title), values, None) for title, values in data.items()]
        return _timed(kind("mapping"), columns)
    return Held(kind("array"), [_column(kind("array"), "", data, None)])


def _of_frame(kind: str, frame: Any) -> Held:
    titles = [str(title) for title in frame.columns]
    numeric = [n for n in range(len(titles)) if frame.dtypes.iloc[n].kind in "fiumM"]
    columns = [_column(kind, titles[n], _values(frame.iloc[:, n]), "") for n in numeric]
    others = (frame.iloc[:, n] for n in range(len(titles)) if n not in numeric)
    columns += [_column(kind, str(each.name), _dates(kind, each), "") for each in others if _is_dated(each)]
    if frame.index.name is not None or frame.index.dtype.kind in "mM":
        columns.append(_column(kind, str(frame.index.name or "time"), _values(frame.index), ""))
    return _timed(kind, columns)


def _values(series: Any) -> NDArray[Any]:
    """Values of a column or an index; dates with a zone in UTC."""
    values: NDArray[Any] = series.to_numpy("datetime64[ns]" if series.dtype.kind == "M" else None)
    return values


def _is_dated(series: Any) -> bool:
    return len(series) > 0 and isinstance(series.iloc[0], str) and is_dated(series.iloc[0])


def _dates(kind: str, series: Any) -> NDArray[np.datetime64]:
    """Dates of a column of texts."""
    try:
        return np.array([instant(str(text)).nanoseconds for text in series]).astype("datetime64[ns]")
    except ValueError as error:
        raise DataError(f"{kind}: column {str(series.name)!r}: {error}") from None


def _of_dataset(kind: str, variables: Mapping[str, Any]) -> Held:
    dims = {
        name: "time" if "time" in each.dims else (each.dims or ("",))[-1] for name, each in variables.items()
    }
    along = "time" if "time" in dims.values() else next(iter(dims.values()), "")
    chosen = {name: each for name, each in variables.items() if along in each.dims}
    columns = [
        _column(kind, name, each.transpose(..., along).to_numpy(), _usual(str(each.attrs.get("units", ""))))
        for name, each in chosen.items()
    ]
    leading = next((each for each in chosen.values() if each.ndim > 1), None)
    names = {} if leading is None else _names(leading, along)
    times = next((each.coords[along] for each in chosen.values() if along in each.coords), None)
    if times is None:
        return Held(kind, columns, None, **names)
    unit = _usual(str(times.attrs.get("units", "")))
    return Held(kind, columns, _column(kind, along, times.to_numpy(), unit), **names)


def _names(data: Any, along: str) -> dict[str, list[str]]:
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


def _timed(kind: str, columns: Sequence[Column]) -> Held:
    """Columns, that of time set apart."""
    titles = [column.name for column in columns]
    places = named_time(titles, lambda n: columns[n].unit or "", lambda n: columns[n].is_dates)
    if len(places) > 1:
        raise DataError(f"{kind}: has more than one column of time")
    others = [column for place, column in enumerate(columns) if place not in places]
    return Held(kind, others, columns[places[0]] if places else None)


def _column(kind: str, title: str, values: Any, unit: str | None) -> Column:
    """A column by its header; a unit in the header comes first."""
    array, stated = _samples(values), split_title(title)[1]
    if array.dtype.kind in "mM":
        passed = (array - array[:1]) / np.timedelta64(1, "ns") / 1e9
        since = array[:1].astype(f"{array.dtype.kind}8[ns]").astype(np.int64).sum() / 1e9
        return Column(title, passed, "s", float(since), is_dates=True)
    if array.dtype.kind not in "fiu":
        raise DataError(
            f"{kind}: {f'column {title!r} ' if title else ''}contains something other than real numbers"
        )
    if array.ndim not in (1, 2):
        raise DataError(f"{kind}: has {counted(array.ndim, 'dimension')}; give samples, or records × samples")
    if array.ndim == 2 and array.shape[1] == 1 < array.shape[0]:
        raise DataError(
            f"{kind}: shape {array.shape} is {counted(array.shape[0], 'record')}"
            " of 1 sample; transpose it or ravel it"
        )
    return Column(title, array.astype(np.float64), stated or unit)


def _samples(values: Any) -> NDArray[Any]:
    """Values as an array; masked ones are missing (NaN)."""
    parts = values if isinstance(values, list | tuple) else [values]
    if not any(isinstance(each, np.ma.MaskedArray) for each in parts):
        return np.asarray(values)
    masked = np.ma.asarray(values)
    array, is_missing = np.array(masked.data), np.ma.getmaskarray(masked)
    array = array.astype(np.float64) if array.dtype.kind in "iu" else array
    if array.dtype.kind in "fmM":
        array[is_missing] = np.array("NaT", array.dtype) if array.dtype.kind in "mM" else np.nan
    return array


def _usual(unit: str) -> str:
    """A unit in the style of CF, such as ``m s-1``, as hydrofdi reads it."""
    return _CF_POWER.sub(r"^\1", unit)


def records_of(data: Held, frequency: float | None, channel: Names, unit: Names) -> HeldSource:
    """Records of columns."""
    if not isinstance(unit, str | Mapping | None):
        raise refusal("unit", "a unit, or column → unit", unit)
    time = data.time
    if frequency is not None and time is not None:
        if not counts_samples(time.values):
            raise DataError(f"{data.kind}: has a column {time.name!r}; leave the sampling frequency out")
        time = None
    if frequency is None and time is None:
        raise DataError(
            f"{data.kind}: no sampling frequency is given (sampling_frequency='1 kHz'), and nothing is named"
            " 'time'"
        )
    chosen = _chosen(data, channel)
    columns = [*chosen.values(), *([time] if time is not None else [])]
    titles = [column.title for column in columns]
    names = [title if title and titles.count(title) == 1 else str(n) for n, title in enumerate(titles, 1)]
    given = [_given(unit, *each) for each in chosen.items()]
    units = [column.unit or "" for column in columns]
    for n, (found, column) in enumerate(chosen.items()):
        if column.unit is None and not given[n]:
            units[n] = found.unit
    sampling: dict[str, Any] = {"sampling_frequency": frequency}
    if time is not None:
        stated = unit.get(time.name, "") if isinstance(unit, Mapping) else ""
        sampling = {"time": {"column": names[-1], "unit": stated}}
    lengths = {len(column.values) for column in columns if column.values.ndim > 1} or {1}
    n_record = max(lengths)
    if n_record == 0:
        raise DataError(f"{data.kind}: contains no records")
    if len(lengths) > 1:
        raise DataError(f"{data.kind}: has {min(lengths)} records of one channel and {n_record} of another")
    named = (data.record_ids or [*map(str, range(n_record))], data.groups, data.labels)
    samples = [column.values for column in columns]
    tables = [
        HeldTable(data.kind, titles, units, [each if each.ndim == 1 else each[row] for each in samples], *own)
        for row, own in enumerate(zip(*(texts or [""] * n_record for texts in named), strict=True))
    ]
    described = zip(chosen, names, given, strict=False)
    return held_source(
        tables, {found: {"column": name, "unit": text} for found, name, text in described}, sampling
    )


def _given(unit: Names, channel: Channel, column: Column) -> str:
    """The unit that is said of a column; empty if none is."""
    if not isinstance(unit, Mapping):
        return unit or ""
    own = (column.title, column.name)
    return next((unit[name] for name in unit if name in own or channel_named(name, "") == channel), "")


def _chosen(data: Held, channel: Names) -> dict[Channel, Column]:
    """The columns that are channels: those that are said to be, or are named like one."""
    columns, titles = data.columns, [column.title for column in data.columns]
    if isinstance(channel, Mapping):
        return {
            _channel(name): columns[find_column(titles, str(column), data.kind)]
            for column, name in channel.items()
        }
    wanted = None if channel is None else _channel(channel)
    if len(columns) == 1 and (wanted or not titles[0]):
        return {wanted or Channel.CHAMBER_1_PRESSURE: columns[0]}
    named = channels_named(titles, lambda n: columns[n].unit or "", data.kind)
    chosen = {found: columns[n] for found, n in named.items() if wanted in (None, found)}
    if not chosen:
        listing = ", ".join(map(repr, titles)) or "no column of numbers"
        raise DataError(
            f"{data.kind}: no column is named like {wanted or 'a channel'}; found {listing};"
            " give channel={'column': 'P1'}"
        )
    return chosen


def _channel(name: str) -> Channel:
    if not isinstance(name, str):
        raise refusal("channel", "the name of a channel, or column → name", name)
    return channel_called(name)
