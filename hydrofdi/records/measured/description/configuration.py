"""The description of measured files: a YAML file beside them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from hydrofdi.records.channels import Channel
from hydrofdi.records.measured.description.sections import (
    ChannelConfig,
    CyclesConfig,
    FormatConfig,
    LimitsConfig,
    SegmentConfig,
    TimeConfig,
    TrimConfig,
    one_or_more,
)
from hydrofdi.settings.quantities import SI, Section

Frequency = Annotated[float, SI("Hz", above=0.0)]


class MeasuredConfig(Section):
    """Measured files, what their columns are, and how they become records."""

    files: Annotated[tuple[str, ...], one_or_more(str), Field(min_length=1)]
    """Pattern of paths relative to the folder of this file, or a list of them, with ``*``, ``?``, ``[…]``,
    ``**``. Spaces need no escaping. Leading parts that exist literally, including brackets, are taken
    literally."""

    channels: dict[Channel, ChannelConfig] = Field(default_factory=dict)
    """Channel, by name or symbol such as ``P1`` → column. By default the header of the first file states
    them, as in ``P1 [bar]``, and the column of time, as in ``time [s]``."""

    sampling_frequency: Frequency | None = None
    """Sampling frequency; either this or `time`."""

    sampling_frequency_is: Literal["given", "inferred"] = "given"
    """``inferred`` if it is undocumented; every record then carries a remark."""

    time: TimeConfig | None = None
    """Column of sampling instants; either this or `sampling_frequency`."""

    resample: Frequency | None = None
    """Sampling frequency to which records with a time column are interpolated linearly. Otherwise uneven
    sampling only causes a remark."""

    format: FormatConfig = FormatConfig()

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

    label: str = ""
    """Known condition of a record: a template like `group`. Only evaluations use it."""

    healthy: Annotated[tuple[str, ...], one_or_more(str)] = ()
    """Labels of healthy records; records with any other label are faulty. Only evaluations use it."""

    severity: dict[str, Annotated[float, SI("m^3/s", above=0.0)]] = Field(default_factory=dict)
    """Label → leakage flow of its records, if known. Only evaluations use it."""

    normalize: Literal["none", "supply", "hold"] = "none"
    """``supply``: pressures are divided by the mean of the supply pressure. ``hold``: by the mean of the
    higher chamber pressure in the last fifth of the file or cycle. Pressures are then relative."""

    limits: LimitsConfig = LimitsConfig()

    @field_validator("format", mode="before")
    @classmethod
    def _kind_alone(cls, value: Any) -> Any:
        return {"kind": value} if isinstance(value, str) else value
