"""One measured file without a description: its columns have to say what they are."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from hydrofdi.errors import DataError
from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import FormatConfig
from hydrofdi.records.measured.formats.opening import open_table
from hydrofdi.records.measured.formats.table import Table, split_title
from hydrofdi.records.measured.rejection import RejectionError
from hydrofdi.records.measured.source import MeasuredSource, described
from hydrofdi.settings.yaml_source import Source

_FORMS = {
    Channel.CHAMBER_1_PRESSURE: "p1, pressure 1, chamber 1 pressure, chamber pressure 1, p chamber 1",
    Channel.CHAMBER_2_PRESSURE: "p2, pressure 2, chamber 2 pressure, chamber pressure 2, p chamber 2",
    Channel.SUPPLY_PRESSURE: "ps, p supply, supply pressure, pressure supply",
    Channel.RETURN_PRESSURE: "pr, pt, p return, p tank, return pressure, tank pressure",
    Channel.PISTON_POSITION: "x, xp, position, piston position",
    Channel.PISTON_VELOCITY: "v, vp, velocity, piston velocity",
    Channel.SPOOL_POSITION: "xv, xs, spool, spool position, valve position",
    Channel.INPUT_VOLTAGE: "u, voltage, input voltage, command voltage",
}
"""Channel → names that columns use for it; letters' case, blanks, ``_``, ``-`` and ``.`` do not matter."""

_CHANNELS = {form.replace(" ", ""): channel for channel, text in _FORMS.items() for form in text.split(", ")}
_TIMES = {"t", "time"}
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
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None
    return MeasuredSource(str(path), file.parent, described(Source(data)), [file])


def _description(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, object]:
    if not table.titles:
        raise DataError(f"{file}: holds no columns")
    channels: dict[str, dict[str, str]] = {}
    for position, title in enumerate(table.titles):
        channel = _CHANNELS.get(_short(title))
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


def _sampling(table: Table, file: Path, sampling_frequency: float | None) -> dict[str, object]:
    times = [title for n, title in enumerate(table.titles) if _short(title) in _TIMES and table.unit(n)]
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
    known = {channel: n for n, title in enumerate(table.titles) if (channel := _CHANNELS.get(_short(title)))}
    channel, position = next(iter(known.items()), (Channel.CHAMBER_1_PRESSURE, 0))
    unit = table.unit(position) or "bar" if channel in known else "bar"
    column = f"{{column: {split_title(table.titles[position])[0]!r}, unit: {unit}}}"
    return DataError(
        f"{file}: {what}; describe it in a YAML: {{files: {file.name!r}, sampling_frequency: 1 kHz,"
        f" channels: {{{channel}: {column}}}}}"
    )


def _short(title: str) -> str:
    return re.sub(r"[\s_.\-]+", "", split_title(title)[0]).lower()


def _first(titles: Sequence[str]) -> str:
    return ", ".join(titles[:_MOST_SHOWN]) + (", …" if len(titles) > _MOST_SHOWN else "")
