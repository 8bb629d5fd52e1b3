"""Channels, units and sampling from the headers of files; else a description to paste."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from textwrap import indent

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.columns import MOST_SHOWN, RejectionError, Table, columns_of, shortened, split_title
from hydrofdi.records.data_sheet import usual_sheet_lines
from hydrofdi.records.description import ChannelConfig, MeasuredConfig, TimeConfig, known_unit
from hydrofdi.records.opening import open_table
from hydrofdi.records.proposals import proposed_description
from hydrofdi.records.proposed_time import is_counter
from hydrofdi.records.times import require_seconds, time_column, titles_of_time


def completed(
    config: MeasuredConfig, files: Sequence[Path], *, is_plain: bool = False
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    """A description with the channels that the first readable file states, and a remark on unused columns.

    Its sampling is kept; if it `is_plain`, a column of time beside a sampling frequency is refused. Without a
    readable file it has no channels.
    """
    for file in files:
        table_of = open_table(file, str(file), config.format)
        with suppress(RejectionError), np.errstate(all="ignore"), table_of as table:
            if not table.titles:
                raise DataError(f"{file}: contains no columns")
            return _completed(config, table, file, is_plain)
    return config, ()


def _completed(
    config: MeasuredConfig, table: Table, file: Path, is_plain: bool
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    names = [split_title(title)[0] for title in table.titles]

    def column(position: int) -> str:
        """The name without the unit: other files may have the same column in another unit."""
        if names.count(names[position]) == 1 and names[position]:
            return names[position]
        return (
            table.titles[position] if table.titles.count(table.titles[position]) == 1 else str(position + 1)
        )

    try:
        found = columns_of(table, {})
        used = [each.position for each in found.values()]
        channels = {channel: ChannelConfig(column=column(each.position)) for channel, each in found.items()}
        time = config.time
        times = [] if time is None else [table.find(time.column)]
        if time is None and config.sampling_frequency is None:
            times = [_time_in(table, file)]
            time = TimeConfig(column=column(times[0]))
    except DataError as error:
        raise _advised(file, str(error).removeprefix(f"{file}: ")) from None
    if config.sampling_frequency is not None:
        times = [position for position in titles_of_time(table) if known_unit(table.unit(position))]
        if times and is_plain:
            title = table.titles[times[0]]
            raise DataError(f"{file}: has a column {title!r}; leave the sampling frequency out")
    left = [title for n, title in enumerate(table.titles) if n not in (*used, *times)]
    shown = ", ".join(map(shortened, left[:MOST_SHOWN])) + ", …" * (len(left) > MOST_SHOWN)
    unused = (Issue(f"columns not used: {shown}", kind="unused"),) if left else ()
    return config.model_copy(update={"channels": channels, "time": time}), unused


def _time_in(table: Table, file: Path) -> int:
    """Position of the column of time."""
    time = time_column(table, None)
    if time is None:
        message = (
            "no sampling frequency is given (sampling_frequency=1kHz), and no column is named 'time [s]'"
        )
        raise DataError(f"{file}: {message}")
    if is_counter(table, time.position):
        raise DataError(f"{file}: column {time.title!r} counts the samples and is not a time")
    if not (table.unit(time.position) or table.is_dated(time.position)):
        require_seconds(table.numbers(time.position), f"{file}: column {time.title[:60]!r}")
    return time.position


def _advised(file: Path, what: str) -> DataError:
    """The error that something is missing, with a description to paste."""
    lines = indent(proposed_description(file, file.name), "    ")
    return DataError(f"{file}: {what}; describe it in a YAML file:\n{lines}")


def suggested_description(file: Path, pattern: str, sampling_frequency: float | None) -> str:
    """YAML of a description of files with what the headers of one state, and a data sheet as comments."""
    return "\n".join([proposed_description(file, pattern, sampling_frequency), *usual_sheet_lines()]) + "\n"
