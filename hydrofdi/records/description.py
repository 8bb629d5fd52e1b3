"""The description of measured files: a YAML file beside them."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from hydrofdi.errors import Issue
from hydrofdi.records import Channel
from hydrofdi.records.data_sheet import StatedMachine
from hydrofdi.settings.files import Source
from hydrofdi.settings.messages import nearest
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.units import Unit, parse_unit, similar_units

Duration = Annotated[float, SI("s", above=0.0)]
Share = Annotated[float, SI("1", above=0.0, most=1.0)]


def _as_text(value: Any) -> Any:
    return str(value) if isinstance(value, int | float) and not isinstance(value, bool) else value


def one_or_more(kind: Any) -> BeforeValidator:
    """One entry, or a list of them, as a tuple."""
    return BeforeValidator(
        lambda value: tuple(value) if isinstance(value, list | tuple) else (value,),
        json_schema_input_type=kind | list[kind],
    )


COUNTS = {"counts", "count", "cts", "lsb"}
"""Units that mean the counts of a converter."""


def is_counts(unit: str) -> bool:
    """Whether a unit means the counts of a converter."""
    return unit.lower() in COUNTS


def known_unit(text: str) -> Unit | None:
    """The unit that a text means; None if hydrofdi does not know it."""
    try:
        return parse_unit(text)
    except ValueError:
        return None


def unit_mistake(unit: str, si_unit: str) -> str:
    """What is wrong with the unit of a column; empty if nothing is."""
    known = None if is_counts(unit) else known_unit(unit)
    if is_counts(unit) or (known is not None and known.exponents == parse_unit(si_unit).exponents):
        return ""
    if known is not None:
        return f"the unit {unit} is not convertible to {si_unit}"
    hint = "give 'gain' and the 'unit' after the gain, or 'unit: counts' if the scale is unknown"
    if similar := similar_units(unit, si_unit):
        hint = f"did you mean {' or '.join(map(repr, similar))}?"
    return f"unknown unit {unit!r}; {hint}"


Column = Annotated[str, BeforeValidator(_as_text, json_schema_input_type=str | int)]
"""Name of a column, or its number."""


class LongConfig(Section):
    """Columns of a table with a row for each value, as loggers of tags write it."""

    name: Column
    """Column with the names."""

    value: Column
    """Column with the values."""


class FormatConfig(Section):
    """Format of the files. By default, suffix and first lines show kind, delimiter, header and units."""

    short_forms = ({"type": "string"},)

    kind: Literal["text", "hdf5", "mat", "mdf", "tdms", "parquet", "npz"] | None = None
    """Kind of file; by default from the suffix. ``.gz`` may follow every suffix."""

    delimiter: Annotated[str, Field(min_length=1, max_length=5)] | None = None
    """Separator of the columns of a text: one character, ``tab`` or ``space`` (one or more spaces). By
    default detected from the first line: tab, then ``;``, ``,``, ``|``, blanks."""

    decimal: Literal[".", ","] = "."
    """Decimal sign of a text."""

    thousands: Literal[",", ".", " ", "'"] | None = None
    """Sign between the thousands of a text, if it has one."""

    units_in_cells: bool = False
    """Whether each cell of a text ends with the unit of its column, as in ``86.0bar``."""

    long: LongConfig | None = None
    """Of a text with a row for each value: the columns of names and of values. The names are the columns."""

    comment: str = "#"
    """Lines of a text that start with this are ignored."""

    skip: Annotated[int, Field(ge=0)] = 0
    """Number of lines of a text before the header, or before the first row."""

    header: bool | None = None
    """Whether a text has a line of column names; by default detected from the first line."""

    units_row: bool | None = None
    """Whether a line of units follows the header; by default detected from that line."""

    missing: Annotated[tuple[Column, ...], one_or_more(str | int)] = ()
    """Texts that mean a missing value, such as ``-9999``, in addition to an empty cell, ``nan``, ``NA`` and
    ``null``."""

    encoding: str = "utf-8"
    """Encoding of a text."""


class ChannelConfig(Section):
    """Source of a channel: sign × (gain × column + offset), in `unit`. A plain text means the column."""

    short_forms = ({"type": "string"}, {"type": "integer"})

    column: Column
    """Name of the column, with or without its unit, or its number from 1; path of the dataset in HDF5 and
    MAT. ``data[2]`` is the second column of a table ``data``."""

    unit: str = ""
    """Unit after gain and offset, such as ``bar``; ``counts`` if the scale is unknown: the channel is then
    relative. By default from the header."""

    gain: Annotated[float, SI("1")] | None = None
    """Factor of the column. A header's unit may differ from `unit` only if a gain is given."""

    offset: Annotated[float, SI("1")] = 0.0
    """Offset in `unit`, added after the gain."""

    sign: Literal[1, -1] = 1
    """-1 inverts the channel."""

    time: Column | None = None
    """Own time column, in the unit of `time`: the channel is interpolated linearly at the instants of `time`.
    By default the last one to the left, if more than one has the same name."""

    range: tuple[float | str, float | str] | None = None
    """Lowest and highest plausible value, such as ``[0, 350 bar]``; numbers are in SI, or in counts."""

    @model_validator(mode="before")
    @classmethod
    def _column_alone(cls, value: Any) -> Any:
        return {"column": value} if isinstance(value, str | int) and not isinstance(value, bool) else value

    def plausible_range(self, si_unit: str) -> tuple[float, float] | None:
        """Lowest and highest plausible value in SI, or in counts; None if none are given."""
        if self.range is None:
            return None
        si = SI("1" if self.unit.lower() in COUNTS else si_unit)
        low, high = (si.parse(value) if isinstance(value, str) else float(value) for value in self.range)
        if not low < high:
            raise ValueError(f"the first value must be below the second; found {low:g} and {high:g}")
        return low, high


class TimeConfig(Section):
    """The column with the sampling instants: numbers, or dates with times of day."""

    column: Column
    """Name of the column, or its number from 1."""

    unit: str = ""
    """Unit of the column; by default from the header. Without a stated unit, numbers under the name ``time``
    are in seconds. Dates need none. A column of sample numbers is not a time."""

    date: Column | None = None
    """Column of dates of a text, if `column` has times of day alone."""

    format: str = ""
    """Format of dates of a text, such as ``%d/%m/%Y %I:%M:%S.%f %p``; by default as in ISO 8601, or
    ``31.01.2026 12:00:00,25``."""


class TrimConfig(Section):
    """Parts to cut off each file."""

    start: Annotated[float, SI("s", least=0.0)] = 0.0
    """Duration that is cut off at the start."""

    end: Annotated[float, SI("s", least=0.0)] = 0.0
    """Duration that is cut off at the end."""


class CyclesConfig(Section):
    """Division of a file into cycles, each of which becomes a record."""

    by: Literal["period", "edges"]
    """``period``: equal durations from the first sample on. ``edges``: from each edge of `channel` to the
    next."""

    period: Duration | None = None
    """Duration of a cycle, for ``period``. It becomes the period of the drive."""

    channel: Channel = Channel.INPUT_VOLTAGE
    """Channel whose edges define the cycles."""

    edge: Literal["rising", "falling", "both"] = "rising"
    """Which edges count; an edge is where the channel crosses the middle of its range."""

    length: Duration | None = None
    """Duration used of each cycle, from its start; shorter cycles are rejected. By default the whole
    cycle."""


class SegmentConfig(Section):
    """The part of each stroke that becomes the record, found from the piston position."""

    part: Literal["motion", "impact", "hold"]
    """``motion``: from 2 % to 98 % of the stroke. ``impact``: around the arrival at 98 %. ``hold``: from
    `settle` after it to the end."""

    before: Annotated[float, SI("s", least=0.0)] = 0.06
    """Duration before the arrival that belongs to the impact."""

    settle: Annotated[float, SI("s", least=0.0)] = 0.5
    """Duration between the arrival and the hold."""

    length: Duration | None = None
    """Duration used of the part; shorter parts are rejected. By default the whole part; required for an
    impact."""


class RemarkLimits(Section):
    """Thresholds of the remarks."""

    clipped: Share = 0.02
    """Share of a pressure's samples at its lowest or highest value, if there are far more than at the
    neighbouring value."""

    hum: Share = 0.5
    """Share of a channel's power above 20 Hz in steady lines at the mains frequency and its harmonics. A
    decaying mode does not count."""

    mains: Annotated[tuple[Annotated[float, SI("Hz", above=0.0)], ...], one_or_more(float | str)] = (
        50.0,
        60.0,
    )
    """Mains frequencies to look for."""

    uneven: Share = 0.1
    """Distance of a sampling instant from even sampling, as a share of a step."""

    samples: Annotated[int, Field(ge=2)] | None = None
    """Expected number of samples of a record."""

    shortest_stroke: Annotated[float, SI("m", above=0.0)] | None = None
    """Distance between the first and the last piston position; in counts if the position is in counts."""

    payload: Annotated[int, Field(ge=1024, le=2**28)] = 2**20
    """Largest message or line of a stream [bytes]; a longer one is counted as malformed and skipped."""


Frequency = Annotated[float, SI("Hz", above=0.0)]


class SamplesConfig(Section):
    """What the columns are: of files, and of streams."""

    channels: dict[Channel, ChannelConfig] = Field(default_factory=dict)
    """Channel, by name or symbol such as ``P1`` → column of a text or an array, key of a JSON object, or node
    of an OPC UA server. By default the header of the first file, or the keys, state them, as in ``P1 [bar]``,
    and the column of time, as in ``time [s]``."""

    sampling_frequency: Frequency | None = None
    """Sampling frequency; either this or `time`."""

    time: TimeConfig | None = None
    """Column of sampling instants; either this or `sampling_frequency`."""

    actuator: StatedMachine = StatedMachine()
    """Data sheet of the machine, which indicators that need it use, unless their options state otherwise."""

    format: FormatConfig = FormatConfig()

    limits: RemarkLimits = RemarkLimits()

    @field_validator("format", mode="before")
    @classmethod
    def _kind_alone(cls, value: Any) -> Any:
        return {"kind": value} if isinstance(value, str) else value


OF_STREAMS = ("zone", "mqtt", "opcua")
"""Keys of a description that only a monitor reads."""


class MeasuredConfig(SamplesConfig):
    """Measured files, what their columns are, and how they become records."""

    files: Annotated[tuple[str, ...], one_or_more(str), Field(min_length=1)]
    """Pattern of paths relative to the folder of this file, or a list of them, with ``*``, ``?``, ``[…]``,
    ``**``. Spaces need no escaping. Leading parts that exist literally, including brackets, are taken
    literally."""

    sampling_frequency_is: Literal["given", "inferred"] = "given"
    """``inferred`` if it is undocumented; every record then carries a remark."""

    resample: Frequency | None = None
    """Sampling frequency to which records with a time column are interpolated linearly. Otherwise uneven
    sampling only causes a remark."""

    trim: TrimConfig = TrimConfig()

    cycles: CyclesConfig | None = None

    segment: SegmentConfig | None = None

    drive_period: Annotated[float, SI("s", above=0.0)] | None = None
    """Period of the drive, if it has one."""

    path: str = ""
    """Names in the path of a file: a template such as ``{unit}/run {run}.csv``, or a regular expression with
    ``(?P<unit>…)``. The end of the path must match; a name in braces matches as little as possible."""

    group: str = ""
    """Group of a record: a template with names in braces. Names are those of `path`, ``{folder}``,
    ``{file}`` and ``{direction}`` (``+``, ``-`` or ``0``: the sign of the last minus the first
    piston position). Records with the same text form a group."""

    date: str = ""
    """Date of each file, for `hydrofdi trend`: a template like `group` that makes a date, such as
    ``{date}`` for 2026-01-31 in the path. By default a time column with dates states it."""

    label: str = ""
    """Known condition of a record: a template like `group`. Only evaluations use it."""

    healthy: Annotated[tuple[str, ...], one_or_more(str)] = ()
    """Labels of healthy records; records with any other label are faulty. Only evaluations use it."""

    severity: dict[str, Annotated[float, SI("m^3/s", above=0.0)]] = Field(default_factory=dict)
    """Label → leakage flow of its records, if known. Only evaluations use it."""

    normalize: Literal["none", "supply", "hold"] = "none"
    """``supply``: pressures are divided by the mean of the supply pressure. ``hold``: by the mean of the
    higher chamber pressure in the last fifth of the file or cycle. Pressures are then relative."""


_FIELD = re.compile(r"\{([A-Za-z_][A-Za-z0-9_]*)\}")
OWN_NAMES = ("folder", "file", "direction")
"""Names that every record has."""


def path_pattern(template: str) -> re.Pattern[str]:
    """The regular expression of a template of paths."""
    if not template or "(?P<" in template:
        return re.compile(f"(?:{template})$" if template else "")
    pieces = _FIELD.split(template)
    texts, names = [re.escape(piece) for piece in pieces[::2]], pieces[1::2]
    # a name ends where the text behind it first occurs; only the last one may have to look further. What a
    # look-ahead found is not tried again; possessive quantifiers would do, but Python 3.11.2 errs in them.
    fields = [
        f"(?=(?P<{name}>[^/](?:(?!{text})[^/])*))(?P={name})"
        for name, text in zip(names, texts[1:], strict=True)
    ]
    fields[-1:] = [f"(?P<{name}>[^/]+?)" for name in names[-1:]]
    return re.compile("".join(a + b for a, b in zip(texts, [*fields, ""], strict=True)) + "$")


def names_of_path(place: str, pattern: re.Pattern[str]) -> dict[str, str] | None:
    """Name → value in a path; None if it does not match."""
    match = pattern.search(place)
    if match is None:
        return None
    path = PurePosixPath(place)
    own = {"folder": path.parent.name, "file": path.name}
    return own | {name: value or "" for name, value in match.groupdict().items()}


def fields_of(template: str) -> list[str]:
    """Names in braces in a template."""
    return _FIELD.findall(template)


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with its names replaced."""
    return _FIELD.sub(lambda match: values[match[1]], template)


def contradictions(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    """Mistakes that concern more than one key, with their lines."""
    yield from _sampling(config, source)
    yield from channel_mistakes(config.channels, source)
    yield from _needed_channels(config, source)
    yield from _names(config, source)
    yield from _labels(config, source)
    try:
        codecs.lookup(config.format.encoding)
    except LookupError:
        message = f"unknown encoding {config.format.encoding!r}; for example utf-8 or latin-1"
        yield source.mistake(("format", "encoding"), message)
    delimiter = config.format.delimiter
    if delimiter is not None and len(delimiter) > 1 and delimiter not in ("tab", "\\t", "space"):
        yield source.mistake(("format", "delimiter"), f"one character, tab or space; found {delimiter!r}")
    if delimiter in ('"', "\n", "\r"):
        yield source.mistake(("format", "delimiter"), f"{delimiter!r} cannot separate columns")
    if config.format.thousands == config.format.decimal:
        yield source.mistake(("format", "thousands"), f"{config.format.decimal!r} is also the decimal sign")


def channel_mistakes(channels: Mapping[Channel, ChannelConfig], source: Source) -> Iterator[Issue]:
    """Mistakes in units, ranges and gains of columns, and what is given twice."""
    written: dict[Channel, str] = {}
    for name in source.data.get("channels") or ():
        if (first := written.setdefault(Channel(name), name)) != name:
            yield source.mistake(("channels", name), f"is given twice, as {first!r} too")
    of_column: dict[str | None, Channel] = {}
    for channel, column in channels.items():
        if column.column and (other := of_column.setdefault(column.column, channel)) != channel:
            yield source.mistake(
                ("channels", written.get(channel, channel.value)), f"has the column of {other}"
            )
        path = ("channels", written.get(channel, channel.value))
        if column.unit and (mistake := unit_mistake(column.unit, channel.unit)):
            yield source.mistake((*path, "unit"), mistake)
        try:
            column.plausible_range(channel.unit)
        except ValueError as error:
            yield source.mistake((*path, "range"), str(error))
        if column.gain == 0.0:
            yield source.mistake((*path, "gain"), "must not be zero")


def _sampling(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    if config.time is None and config.sampling_frequency is None:
        message = "is missing; give 'sampling_frequency: 1 kHz', or 'time: {column: …, unit: s}'"
        yield source.mistake(("sampling_frequency",), message)
    if config.time is not None and config.sampling_frequency is not None:
        yield source.mistake(("sampling_frequency",), "is given as well as 'time'; give only one of them")
    if config.resample is not None and config.time is None:
        yield source.mistake(("resample",), "needs 'time', a column of sampling instants")
    if config.time is not None and config.time.unit and (mistake := unit_mistake(config.time.unit, "s")):
        yield source.mistake(("time", "unit"), mistake)


def _needed_channels(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    needs = [
        (("segment",), config.segment is not None, Channel.PISTON_POSITION),
        (("limits", "shortest_stroke"), config.limits.shortest_stroke is not None, Channel.PISTON_POSITION),
        (("normalize",), config.normalize == "supply", Channel.SUPPLY_PRESSURE),
        (("normalize",), config.normalize == "hold", Channel.CHAMBER_1_PRESSURE),
        (("normalize",), config.normalize == "hold", Channel.CHAMBER_2_PRESSURE),
    ]
    for key in ("group", "label"):
        needs.append(((key,), "direction" in fields_of(getattr(config, key)), Channel.PISTON_POSITION))
    cycles = config.cycles
    if cycles is not None:
        needs.append((("cycles",), cycles.by == "edges", cycles.channel))
        if cycles.by == "period" and cycles.period is None:
            yield source.mistake(("cycles",), "needs a period")
    if config.segment is not None and config.segment.part == "impact" and config.segment.length is None:
        yield source.mistake(("segment",), "an impact needs a length, such as 0.5 s")
    for path, is_asked, channel in needs:
        if is_asked and channel not in config.channels:
            yield source.mistake(path, f"needs the channel {channel}")


def _labels(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    for key in ("healthy", "severity"):
        if getattr(config, key) and not config.label:
            yield source.mistake((key,), "needs 'label', which states the condition of each record")
    for label in config.severity:
        if label in config.healthy:
            yield source.mistake(("severity", label), "is a healthy label and cannot have a severity")


def _names(config: MeasuredConfig, source: Source) -> Iterator[Issue]:
    try:
        pattern = path_pattern(config.path)
    except re.error as error:
        yield source.mistake(("path",), f"is not a regular expression: {error}")
        return
    known = [*pattern.groupindex, *OWN_NAMES]
    for key in ("group", "label", "date"):
        for name in fields_of(getattr(config, key)):
            # a file has a date, but only its cycles have a direction
            if name not in known or (key, name) == ("date", "direction"):
                yield source.mistake((key,), f"unknown name {{{name}}}{nearest(name, known)}")
