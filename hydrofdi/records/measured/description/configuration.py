"""The description of measured files: a YAML beside them."""

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
    """Pattern of paths, or a list of them, from the folder of this file, with ``*``, ``?``, ``[…]``,
    ``**``. Blanks need no care. Leading parts that exist as they are written are taken so, with brackets."""

    channels: Annotated[dict[Channel, ChannelConfig], Field(min_length=1)]
    """Channel → column."""

    sampling_frequency: Frequency | None = None
    """Sampling frequency; either this or `time`."""

    sampling_frequency_is: Literal["given", "inferred"] = "given"
    """``inferred`` where nobody documented it; every record then says so."""

    time: TimeConfig | None = None
    """Column of sampling instants; either this or `sampling_frequency`."""

    resample: Frequency | None = None
    """Sampling frequency to which records with a time column are interpolated, by straight lines. Uneven
    sampling is otherwise remarked and left as it is."""

    format: FormatConfig = FormatConfig()

    trim: TrimConfig = TrimConfig()

    cycles: CyclesConfig | None = None

    segment: SegmentConfig | None = None

    drive_period: Annotated[float, SI("s", above=0.0)] | None = None
    """Period of the drive, where there is one."""

    path: str = ""
    """Names in the path of a file: a template such as ``{unit}/run {run}.csv``, or a regular expression with
    ``(?P<unit>…)``. The end of the path has to match; a name in braces takes as little as it can."""

    columns: dict[str, str] = Field(default_factory=dict)
    """Name → column that holds one value all through a file, such as the day."""

    group: str = ""
    """Group of a record, with names in braces: those of `path` and `columns`, ``{folder}``, ``{file}`` and
    ``{direction}``: ``+`` or ``-``, the sign of the last less the first piston position, or ``0``. What
    shares a unit, a day and a direction shares a group."""

    label: str = ""
    """What is known of a record, such as its condition; in the same words. Only evaluations see it."""

    healthy: Annotated[tuple[str, ...], one_or_more(str)] = ()
    """Labels of healthy records; those with another label are faulty. Only evaluations see it."""

    severity: dict[str, Annotated[float, SI("m^3/s", above=0.0)]] = Field(default_factory=dict)
    """Label → leakage flow of its records, where it is known. Only evaluations see it."""

    normalize: Literal["none", "supply", "hold"] = "none"
    """``supply``: pressures are divided by the mean of the supply pressure. ``hold``: by the mean of the
    higher chamber pressure in the last fifth of the file or cycle. They are relative then."""

    limits: LimitsConfig = LimitsConfig()

    @field_validator("format", mode="before")
    @classmethod
    def _kind_alone(cls, value: Any) -> Any:
        return {"kind": value} if isinstance(value, str) else value
