"""One measured file without a description: its columns have to say what they are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Remark
from hydrofdi.records.measured.column_names import channel_of, time_columns, times_without_unit
from hydrofdi.records.measured.column_units import unit_by_name
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.opening import open_table
from hydrofdi.records.measured.formats.table import Table, shortened
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.records.measured.source import MeasuredSource, described
from hydrofdi.records.measured.suggesting import is_counter, refusal
from hydrofdi.settings.naming import setting
from hydrofdi.settings.yaml_source import Source

_MOST_SHOWN = 12


def plain_file_source(path: Path | str, sampling_frequency: float | None = None) -> MeasuredSource:
    """The record of one file whose column names and units say what they are.

    Parameters
    ----------
    path : path
    sampling_frequency : float, optional
        [Hz]; needed where the file has no column ``time [s]``.

    Raises
    ------
    DataError
        The file does not say enough; the message shows the description to write.
    """
    file = Path(path)
    if not file.is_file():
        raise DataError(f"{file}: {'is a folder' if file.is_dir() else 'no such file'}")
    try:
        with open_table(file, str(file), FormatConfig()) as table:
            data = _description(table, file, sampling_frequency)
            unused = _unused(table, data)
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None
    return MeasuredSource(str(path), file.parent, described(Source(data)), [file], unused)


def _description(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, Any]:
    if not table.titles:
        raise DataError(f"{file}: contains no columns")
    channels: dict[str, dict[str, str]] = {}
    for position, title in enumerate(table.titles):
        channel = channel_of(table, position)
        if channel is None:
            continue
        if channel.value in channels:
            raise refusal(file, f"more than one column is named like {channel}", table)
        if not (table.unit(position) or unit_by_name(title)):
            raise refusal(file, f"column {shortened(title)!r} has no unit", table)
        channels[channel.value] = {"column": title}
    if not channels:
        raise refusal(file, f"no column is named like a channel; found {_first(table.titles)}", table)
    return {"files": file.name, "channels": channels} | _sampling(table, file, sampling_frequency)


def _sampling(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, Any]:
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
            f"no sampling frequency is given ({setting('sampling_frequency', '1kHz')}), and no column is"
            " named 'time [s]'",
            table,
        )
    if is_counter(table, table.find(times[0])):
        raise refusal(file, f"column {times[0]!r} counts the samples and is not a time", table)
    return {"time": {"column": times[0]}}


def _titles(table: Table, positions: Sequence[int]) -> list[str]:
    return [table.titles[position] for position in positions]


def _unused(table: Table, data: dict[str, Any]) -> tuple[Remark, ...]:
    """A remark that names the columns that were not recognised."""
    used = {column["column"] for column in [*data["channels"].values(), data.get("time", {"column": ""})]}
    left = [title for title in table.titles if title not in used]
    return (Remark("unused", f"columns not used: {_first(left)}"),) if left else ()


def _first(titles: Sequence[str]) -> str:
    return ", ".join(map(shortened, titles[:_MOST_SHOWN])) + (", …" if len(titles) > _MOST_SHOWN else "")
