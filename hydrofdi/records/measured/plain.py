"""One measured file without a description: its columns have to say what they are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydrofdi.errors import DataError
from hydrofdi.records.batch import Remark
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.column_names import channel_of, named_like_time, time_columns
from hydrofdi.records.measured.column_units import is_unit
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.opening import open_table
from hydrofdi.records.measured.formats.table import Table, split_title
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.records.measured.source import MeasuredSource, described
from hydrofdi.settings.yaml_source import Source
from hydrofdi.units import similar_units

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
        raise DataError(f"{file}: holds no columns")
    channels: dict[str, dict[str, str]] = {}
    for position, title in enumerate(table.titles):
        channel = channel_of(table, position)
        if channel is None:
            continue
        if channel.value in channels:
            raise _refusal(file, f"more than one column is named like {channel}", table)
        if not table.unit(position):
            raise _refusal(file, f"column {title!r} has no unit", table)
        channels[channel.value] = {"column": title}
    if not channels:
        raise _refusal(file, f"no column is named like a channel; found {_first(table.titles)}", table)
    return {"files": file.name, "channels": channels} | _sampling(table, file, sampling_frequency)


def _sampling(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, Any]:
    times = [table.titles[position] for position in time_columns(table)]
    if len(times) > 1:
        raise _refusal(file, f"has more than one column of time: {_first(times)}", table)
    if sampling_frequency is not None and times:
        raise DataError(f"{file}: has a column {times[0]!r}; leave the sampling frequency out")
    if sampling_frequency is not None:
        return {"sampling_frequency": sampling_frequency}
    if not times:
        raise _refusal(
            file,
            "no sampling frequency is given (--sampling-frequency 1kHz), and no column is named 'time [s]'",
            table,
        )
    return {"time": {"column": times[0]}}


def _refusal(file: Path, what: str, table: Table) -> DataError:
    """What is missing, and the description that would say it."""
    known = ((channel_of(table, n), n) for n in range(len(table.titles)))
    channel, position = next(((c, n) for c, n in known if c), (Channel.CHAMBER_1_PRESSURE, None))
    column = "…" if position is None else split_title(table.titles[position])[0]
    unit = "…" if position is None else _stated_unit(table, position, channel.unit)
    times = named_like_time(table)
    sampling = "sampling_frequency: …"
    if times:
        title = split_title(table.titles[times[0]])[0]
        sampling = f"time: {{column: {title!r}, unit: {_stated_unit(table, times[0], 's')}}}"
    return DataError(
        f"{file}: {what}; describe it in a YAML: {{files: {file.name!r}, {sampling},"
        f" channels: {{{channel}: {{column: {column!r}, unit: {unit}}}}}}}"
    )


def _stated_unit(table: Table, position: int, si_unit: str) -> str:
    """The unit that a header states, in its usual spelling; a placeholder where that is not clear."""
    header = table.unit(position)
    similar = similar_units(header, si_unit)
    return header if is_unit(header) else similar[0] if len(similar) == 1 else "…"


def _unused(table: Table, data: dict[str, Any]) -> tuple[Remark, ...]:
    """A remark that names the columns that were not recognised."""
    used = {column["column"] for column in [*data["channels"].values(), data.get("time", {"column": ""})]}
    left = [title for title in table.titles if title not in used]
    return (Remark("unused", f"columns not used: {_first(left)}"),) if left else ()


def _first(titles: Sequence[str]) -> str:
    return ", ".join(titles[:_MOST_SHOWN]) + (", …" if len(titles) > _MOST_SHOWN else "")
