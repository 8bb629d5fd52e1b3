"""Program that reads arrays of HDF5, MAT, MDF and TDMS files for another process, which starts it.

It imports nothing of this package, so that it starts fast. Requests on standard input and answers on standard
output are pickled; what is read from a file never is.
"""

from __future__ import annotations

import faulthandler
import math
import os
import pickle
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from io import BytesIO
from typing import Any, cast

import numpy as np

_MISSING = {"_FillValue", "missing_value"}
_PACKING = {"scale_factor", "add_offset"} | _MISSING
"""Attributes by which NetCDF packs numbers."""


def open_hdf5(content: Any) -> Any:
    """Open an HDF5 file, which may come from somebody else, for reading."""
    import h5py

    file: Any = h5py.File(content, "r")

    def is_elsewhere(name: bytes, link: Any) -> bool | None:
        if link.type != h5py.h5l.TYPE_HARD:
            return link.type != h5py.h5l.TYPE_SOFT or None
        item = h5py.h5o.open(file.id, name)
        if not isinstance(item, h5py.h5d.DatasetID):
            return None
        stored = item.get_create_plist()
        return stored.get_layout() == h5py.h5d.VIRTUAL or stored.get_external_count() > 0 or None

    try:
        if file.id.links.visit(is_elsewhere, info=True):
            raise OSError("it refers to data in other files; copy them into one")
    except Exception as error:
        file.close()
        raise OSError(*error.args) from None
    return file


Opened = tuple[Mapping[str, Any], dict[str, str], Callable[[], None], dict[str, str], float]
"""Name → array or dataset, name → unit if one is stated, what releases the file, name → that of its time, and
instant from which times count, since 1970 [s]; NaN if it is not stated."""
_FIRST_DATE = 1e9
"""Least instant that is a date: programs write the beginning of their clock if they do not know it [s]."""


class _Lazy:
    """An array that is read when it is asked for."""

    def __init__(self, shape: tuple[int, ...], load: Callable[[], Any]) -> None:
        self.shape, self._load = shape, load

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        return np.asarray(self._load(), dtype)


def _of_groups(
    groups: Sequence[tuple[str, int, Any, Mapping[str, tuple[str, Any]]]], close: Any, since: float
) -> Opened:
    """Channels in groups, of each its name, number of samples, what loads its time, and name → unit and what
    loads a channel. Names that groups share are ``group/name``; the group with most samples is the first."""
    ordered = sorted(groups, key=lambda group: -group[1])
    counts = Counter(name for group in ordered for name in group[3])
    arrays, units, clocks = dict[str, Any](), dict[str, str](), dict[str, str]()
    for number, (group, n_time, times, channels) in enumerate(ordered):
        time = "time" if not number else f"time of {group or number}"
        time = time if time not in arrays else f"{time} ({number})"
        if times is not None:
            arrays[time], units[time] = _Lazy((n_time,), times), "s"
        for own, (unit, load) in channels.items():
            name = own if counts[own] == 1 else f"{group or number}/{own}"
            arrays[name], units[name] = _Lazy((n_time,), load), unit
            if times is not None:
                clocks[name] = time
    stated = {name: unit for name, unit in units.items() if unit}
    return arrays, stated, close, clocks, since if since >= _FIRST_DATE else math.nan


def _mdf(content: str | BytesIO) -> Opened:
    """Channels of MDF, physical values; invalid samples are missing."""
    from asammdf import MDF

    file: Any = MDF(content)

    def load(group: int, channel: int) -> Any:
        signal = file.get(group=group, index=channel)
        invalid = signal.invalidation_bits
        return signal.samples if invalid is None else np.where(invalid, np.nan, signal.samples)

    groups = list[Any]()
    for number, group in enumerate(file.groups):
        master = file.masters_db.get(number)
        names = {each.name: index for index, each in enumerate(group.channels) if index != master}
        channels = {
            name: (str(file.get_channel_unit(group=number, index=index)), partial(load, number, index))
            for name, index in names.items()
        }
        record = group.channel_group
        times = None if master is None else partial(file.get_master, number)
        groups.append((str(getattr(record, "acq_name", "")), int(record.cycles_nr), times, channels))
    return _of_groups(groups, file.close, _seconds(file.header.start_time))


def _tdms(content: str | BytesIO) -> Opened:
    """Channels of TDMS, those with the same increment, start and length as one group."""
    from nptdms import TdmsFile

    file: Any = TdmsFile.open(content)
    channels = [(group, channel) for group in file.groups() for channel in group.channels()]
    stated = [channel.properties.get("wf_start_time") for _, channel in channels]
    starts = [None if at is None else int(np.datetime64(at, "ns").astype("int64")) for at in stated]
    known, groups = {at for at in starts if at is not None}, dict[Any, Any]()
    first = min(known, default=None)
    if len(known) > 1 and None in starts:
        raise OSError("some of its channels begin at different instants, and others do not state theirs")
    for (group, channel), start in zip(channels, starts, strict=True):
        has, later = channel.properties, 0.0 if start is None or first is None else (start - first) / 1e9
        raster = [has.get(f"wf_{key}") for key in ("increment", "start_offset", "start_time")]
        times = partial(_track, channel, later) if raster[0] else None
        key = (group.name, len(channel), *map(str, raster))
        entry = groups.setdefault(key, (group.name, len(channel), times, {}))
        entry[3][channel.name] = str(has.get("unit_string", "")), partial(channel.__getitem__, slice(None))
    return _of_groups([*groups.values()], file.close, math.nan if first is None else first / 1e9)


def _track(channel: Any, later: float) -> Any:
    """Instants of a channel that begins later than the first one [s]."""
    return channel.time_track() + later


def _hdf5(content: str | BytesIO) -> Opened:
    """Datasets of HDF5 by their path."""
    import h5py

    file, datasets = open_hdf5(content), dict[str, Any]()

    def keep(name: str | bytes, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.shape is not None:
            datasets[_text(name)] = item

    file.visititems(keep)
    stated = {
        name: next((item.attrs[key] for key in ("units", "unit") if key in item.attrs), "")
        for name, item in datasets.items()
    }
    units = {name: _text(unit) for name, unit in stated.items() if isinstance(unit, str | bytes)}
    for name in [name for name, item in datasets.items() if item.dtype.names]:
        table = datasets.pop(name)
        datasets |= {
            f"{name}/{field}": _Lazy(table.shape, partial(table.__getitem__, field))
            for field in table.dtype.names
        }
    clocks, since = dict[str, str](), math.nan
    split = [(name, *unit.partition(" since ")[::2]) for name, unit in units.items()]
    # the first unit such as "seconds since 2026-01-31"
    for time, word, date in [parts for parts in split if parts[1] in _WORDS and parts[2]][:1]:
        with suppress(ValueError):
            since, units[time] = _seconds(datetime.fromisoformat(date)), _WORDS[word]
            n_time = datasets[time].shape[:1]
            alike = [name for name, own in datasets.items() if name != time and own.shape[:1] == n_time]
            clocks = dict.fromkeys(alike, time)
    return datasets, units, file.close, clocks, since


_WORDS = {
    "seconds": "s",
    "milliseconds": "ms",
    "microseconds": "µs",
    "minutes": "min",
    "hours": "h",
    "days": "day",
}
"""Units of NetCDF → those of this package."""


def _seconds(date: datetime) -> float:
    """A date since 1970 [s], in UTC if it has no zone."""
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def _unpacked(dataset: Any) -> Any:
    """Values of a dataset, with fill values, scale and offset of NetCDF applied."""
    values, attributes = dataset[()], dataset.attrs
    if not _PACKING & attributes.keys() or np.asarray(values).dtype.kind not in "iuf":
        return values
    missing = np.isin(values, [attributes[key] for key in _MISSING & attributes.keys()])
    scale, offset = attributes.get("scale_factor", 1.0), attributes.get("add_offset", 0.0)
    return np.where(missing, np.nan, np.asarray(values, dtype=np.float64) * scale + offset)


def _mat(content: str | BytesIO) -> Opened:
    """Variables of MAT files up to version 7, and fields of structures as ``structure/field``.

    The unit of a variable is the field with its name in the structure ``units`` beside it: ``rig/units/P1``
    for ``rig/P1``.
    """
    from scipy.io import loadmat

    try:
        variables = loadmat(cast(Any, content), appendmat=False, simplify_cells=True)
    except (NotImplementedError, ValueError):  # of version 7.3
        return _hdf5(content)
    own = {name: value for name, value in variables.items() if not name.startswith("__")}
    leaves = dict(_leaves("", own))
    paths = {name: "/".join((*name.split("/")[:-1], "units", name.split("/")[-1])) for name in leaves}
    stated = {name: leaves[path] for name, path in paths.items() if path in leaves}
    units = {name: str(unit) for name, unit in stated.items() if unit.dtype.kind == "U" and unit.size == 1}
    arrays = leaves.keys() - {paths[name] for name in units}
    return {name: leaves[name] for name in leaves if name in arrays}, units, lambda: None, {}, math.nan


def main() -> None:
    """Serve until standard input ends: open, give an array, close; each within a time limit."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    opened: Opened = {}, {}, lambda: None, {}, math.nan
    openers = {"HDF5": _hdf5, "MAT": _mat, "MDF": _mdf, "TDMS": _tdms}
    while True:
        try:
            seconds, *request = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        faulthandler.dump_traceback_later(seconds, exit=True)
        try:
            answer: Any = None
            if len(request) == 2:
                kind, content = request
                given = content if isinstance(content, str) else BytesIO(content)
                opened = openers[kind](given)
                answer = {name: array.shape for name, array in opened[0].items()}, opened[1], *opened[3:]
            elif request:
                answer = _plain(opened[0][request[0]])
            else:
                opened[2]()
        except Exception as error:
            answer = OSError(" ".join(str(error).split())[:120] or type(error).__name__)
        pickle.dump(answer, answers, protocol=5)
        answers.flush()
        faulthandler.cancel_dump_traceback_later()


def _plain(array: Any) -> Any:
    """Values of an array or a dataset without objects of a library: numbers, dates or texts."""
    values = np.asarray(_unpacked(array) if hasattr(array, "attrs") else array)
    if values.dtype.kind in "biufcSU":
        return values
    return np.array([_text(value) for value in values.reshape(-1).tolist()], dtype=object).reshape(
        values.shape
    )


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    is_listed = isinstance(value, list | np.ndarray) and len(value) and isinstance(value[0], Mapping)
    if is_listed or (isinstance(value, Mapping) and {"Name", "Data"} <= value.keys()):
        # signals of dSPACE: structures with name and data
        for number, entry in enumerate(value if is_listed else [value], 1):
            name = str(entry.get("Name", "")).rpartition("/")[2].strip("\"' ") or str(number)
            yield from _leaves(f"{path}/{name}", entry.get("Data", entry))
    elif isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _leaves(f"{path}/{name}" if path else str(name), inner)
    else:
        yield path, np.asarray(value)


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    main()
