"""The description of measured files: a YAML file beside them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from hydrofdi.records.batch import Channel
from hydrofdi.records.data_sheet import MachineSheet
from hydrofdi.settings.quantities import SI, Section

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

Column = Annotated[str, BeforeValidator(_as_text, json_schema_input_type=str | int)]
"""Name of a column, or its number."""


class FormatConfig(Section):
    """Format of the files. By default, suffix and first lines show kind, delimiter, header and units."""

    short_forms = ({"type": "string"},)

    kind: Literal["text", "hdf5", "mat", "parquet", "npz"] | None = None
    """Kind of file; by default from the suffix. ``.gz`` may follow every suffix."""

    delimiter: Annotated[str, Field(min_length=1, max_length=5)] | None = None
    """Separator of the columns of a text: one character, ``tab`` or ``space`` (one or more spaces). By
    default detected from the first line: tab, then ``;``, ``,``, ``|``, blanks."""

    decimal: Literal[".", ","] = "."
    """Decimal sign of a text."""

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


class TrimConfig(Section):
    """Parts to cut off each file."""

    start: Annotated[float, SI("s", least=0.0)] = 0.0
    """Duration that is cut off at the start."""

    end: Annotated[float, SI("s", least=0.0)] = 0.0
    """Duration that is cut off at the end."""


class CyclesConfig(Section):
    """Division of a file into cycles, each of which becomes a record."""

    by: Literal["period", "edges", "reversals"]
    """``period``: equal durations from the first sample on. ``edges``: from each edge of `channel` to the
    next. ``reversals``: from each turn of the piston position to the next."""

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


class LimitsConfig(Section):
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

    outliers: Annotated[float, SI("1", above=0.0)] | None = None
    """Distance of a stroke, or of the changes of a pressure from sample to sample, from the median of the
    group, in robust standard deviations, such as 5. All files are then read twice; groups of eight or more
    records are checked. Off by default."""

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

    actuator: MachineSheet = MachineSheet()
    """Data sheet of the machine, which indicators that need it use, unless their options state otherwise."""

    format: FormatConfig = FormatConfig()

    limits: LimitsConfig = LimitsConfig()

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

    columns: dict[str, str] = Field(default_factory=dict)
    """Name → column with a single value per file, such as the day."""

    group: str = ""
    """Group of a record: a template with names in braces. Names are those of `path` and `columns`,
    ``{folder}``, ``{file}`` and ``{direction}`` (``+``, ``-`` or ``0``: the sign of the last minus the first
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
