"""Channels, units and sampling from the headers of files; else a description to paste."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from textwrap import indent

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.records.batch import Channel
from hydrofdi.records.columns import (
    MOST_SHOWN,
    RejectionError,
    Table,
    channel_named,
    columns_of,
    is_unit,
    shortened,
    split_title,
    unit_by_name,
)
from hydrofdi.records.data_sheet import usual_sheet_lines
from hydrofdi.records.description import (
    ChannelConfig,
    FormatConfig,
    MeasuredConfig,
    TimeConfig,
    known_unit,
)
from hydrofdi.records.opening import open_table
from hydrofdi.records.stuck import update_rate
from hydrofdi.records.text import TextTable
from hydrofdi.records.times import (
    counts_samples,
    likely_unit,
    named_time,
    require_seconds,
    sampling_of_times,
    time_column,
    titles_of_time,
)
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

_LONGEST_PREAMBLE = 40
"""Lines among which the header of a text file is looked for."""


def completed(
    config: MeasuredConfig, files: Sequence[Path], *, is_plain: bool = False
) -> tuple[MeasuredConfig, tuple[Issue, ...]]:
    """A description with the channels that the first readable file states, and a remark on unused columns.

    Its sampling is kept; if it `is_plain`, a column of time beside a sampling frequency is refused. Without a
    readable file it has no channels.
    """
    for file in files:
        with suppress(RejectionError), open_table(file, str(file), config.format) as table:
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
        return names[position] if names.count(names[position]) == 1 else table.titles[position]

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
    if _is_counter(table, time.position):
        raise DataError(f"{file}: column {time.title!r} counts the samples and is not a time")
    if not (table.unit(time.position) or table.is_dated(time.position)):
        require_seconds(table.numbers(time.position), f"{file}: column {time.title[:60]!r}")
    return time.position


def _advised(file: Path, what: str) -> DataError:
    """The error that something is missing, with a description to paste."""
    lines = indent(_suggestion(file.name, *_below_preamble(file), None), "    ")
    return DataError(f"{file}: {what}; describe it in a YAML file:\n{lines}")


def suggested_description(file: Path, pattern: str, sampling_frequency: float | None) -> str:
    """YAML of a description of files with what the headers of one state; an ellipsis stands for the rest."""
    try:
        skip, table = _below_preamble(file)
    except RejectionError as rejection:
        raise DataError(f"{file}: {rejection}") from None
    return "\n".join([_suggestion(pattern, skip, table, sampling_frequency), *usual_sheet_lines()]) + "\n"


def _below_preamble(file: Path) -> tuple[int, Table]:
    """Number of lines above the header, which names channels or else stands above numbers, and the table."""
    found: list[tuple[int, Table]] = []
    for skip in range(_LONGEST_PREAMBLE):
        with suppress(DataError), open_table(file, str(file), FormatConfig(skip=skip)) as table:
            titles = enumerate(table.titles if table.has_numbers else ())
            are_named = any(channel_named(title, table.unit(n), _CHANNELS) for n, title in titles)
            if are_named or not isinstance(table, TextTable):
                return skip, table
            found += [(skip, table)] * table.has_numbers
    if not found:
        with open_table(file, str(file), FormatConfig()) as table:
            return 0, table
    return found[0]


def _suggestion(pattern: str, skip: int, table: Table, sampling_frequency: float | None) -> str:
    channels: dict[Channel, str] = {}
    left: list[str] = []
    time, sampling = _sampling(table)
    for position, title in enumerate(table.titles):
        if position == time:
            continue
        if channel := channel_named(title, table.unit(position), _CHANNELS):
            channels.setdefault(channel, _column(table, position, channel.unit))
        else:
            left.append(shortened(title))
    columns = channels or {Channel.CHAMBER_1_PRESSURE: "{column: '…', unit: …}"}
    form = ["decimal: ','"] * table.has_decimal_commas + [f"skip: {skip}"] * bool(skip)
    keys = [f"files: {pattern!r}", f"format: {{{', '.join(form)}}}"] if form else [f"files: {pattern!r}"]
    keys += [f"sampling_frequency: {sampling_frequency:g} Hz" if sampling_frequency else sampling]
    if time is not None and not sampling_frequency:
        keys += _resampling(table, time)
    keys += (
        [f"# other columns: {', '.join(left[:MOST_SHOWN])}{', …' * (len(left) > MOST_SHOWN)}"] if left else []
    )
    return "\n".join([*keys, "channels:", *(f"  {channel}: {text}" for channel, text in columns.items())])


def _sampling(table: Table) -> tuple[int | None, str]:
    """A column that may be the time by its name, its dates or its unit, and the sampling to suggest."""
    second = parse_unit("s").exponents
    units = [known_unit(table.unit(position)) for position in range(len(table.titles))]
    others = (n for n, unit in enumerate(units) if table.is_dated(n) or (unit and unit.exponents == second))
    time = next(iter([*named_time(table), *others]), None)
    if time is None or _is_counter(table, time):
        return None, "sampling_frequency: …"
    if table.is_dated(time):
        return time, f"time: {{column: {split_title(table.titles[time])[0]!r}}}"
    likely = ""
    if not table.unit(time):
        with suppress(DataError):
            likely = likely_unit(table.numbers(time))
    return time, f"time: {_column(table, time, 's', likely)}"


def _resampling(table: Table, time: int) -> list[str]:
    """The line that makes uneven records even, with how often channels are really updated."""
    with suppress(DataError, RejectionError, ZeroDivisionError):
        unit = table.unit(time) or likely_unit(table.numbers(time))
        times = table.instants(time)[0]
        times = times if table.is_dated(time) else times * float(parse_unit(unit).factor)
        config = MeasuredConfig(files=("…",))
        if any(each.is_unusable for each in sampling_of_times(times, config, table)[1]):
            rates = list[str]()
            for position, title in enumerate(table.titles):
                if channel_named(title, table.unit(position), _CHANNELS):
                    rate = update_rate(table.numbers(position), times)
                    rates += (
                        [f"{shortened(split_title(title)[0])} is updated at {rate:.3g} Hz"] if rate else []
                    )
            rate = float(f"{1.0 / float(np.median(np.diff(times))):.3g}")
            return [f"resample: {rate:g} Hz" + f"  # {'; '.join(rates)}" * bool(rates)]
    return []


def _column(table: Table, position: int, si_unit: str, likely: str = "") -> str:
    title = shortened(split_title(table.titles[position])[0])
    header = table.unit(position) or likely or unit_by_name(table.titles[position])
    similar = similar_units(header, si_unit)
    unit = header if is_unit(header) else similar[0] if len(similar) == 1 else "…"
    return f"{{column: {title!r}, unit: {unit}}}"


def _is_counter(table: Table, position: int) -> bool:
    """Whether a column without a unit counts the samples."""
    if table.unit(position) or table.is_dated(position):
        return False
    try:
        return counts_samples(table.numbers(position))
    except DataError:
        return False
