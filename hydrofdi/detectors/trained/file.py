"""Schema of detector files: JSON that is validated when read. Nothing in it is executed."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.records.channels import Channel
from hydrofdi.settings.quantities import Section

SCHEMA, VERSION = "hydrofdi.detector", 1

Count = Annotated[int, Field(ge=0)]


class Made(Section):
    """Origin of the file."""

    hydrofdi: str
    """Version of hydrofdi."""

    time: str
    """Time of training, in UTC."""

    command: str = ""
    """Command line."""


class Basis(Section):
    """Data behind the stated false-alarm rate."""

    sources: tuple[str, ...] = Field(min_length=1)
    """Sources of the healthy records."""

    n_record: int = Field(ge=1)
    """Number of healthy records."""

    n_window: int = Field(ge=1)
    """Number of non-overlapping windows that set the threshold."""

    n_group: Count
    """Number of independent groups, such as units or days; 0 if no groups were stated."""

    populations: dict[str, Count]
    """Label of healthy records → number of their windows; empty if there are no labels."""

    not_judged: dict[str, Count]
    """Kind of fault → number of healthy windows that were not used because of it."""

    impossible: dict[str, Count] = Field(default_factory=dict)
    """Output → number of healthy windows in which it is physically impossible."""

    drive_period: float | None = Field(None, gt=0.0)
    """Period of the drive of the first healthy record [s]; null if none is known or found."""


class Scale(Section):
    """Median, spread and range of the healthy score, in the unit of the output."""

    centre: float
    """Median."""

    spread: float = Field(gt=0.0)
    """Interquartile range over 1.349."""

    range: tuple[float, float] | None = None
    """Lowest and highest healthy score; null if the file does not state them."""


class Limits(Section):
    """Limits of the score, in the unit of the output, and the false-alarm rate."""

    low: float | None
    """Lower limit: a score below it is an alarm; null if there is none."""

    high: float | None
    """Upper limit: a score above it is an alarm; null if there is none."""

    false_alarm_rate: float = Field(ge=1e-9, le=0.5)
    """Required fraction of healthy windows that raise an alarm."""

    interval: tuple[float, float]
    """Confidence interval of the true fraction."""

    confidence: float = Field(ge=0.5, le=0.9999)
    """Confidence level of the interval."""

    method: str
    """Method that set the limits."""

    interval_rests_on: Literal["windows", "records", "groups"]
    """``windows``: windows are assumed independent. ``records``, ``groups``: cross-validation, in which each
    record or group is tested with the limits of the others."""


class ChartLimit(Section):
    """Limit of the control chart."""

    limit: float = Field(gt=0.0)
    """Alarm when the statistic reaches it; the chart then restarts."""

    mean_time: float | None
    """Mean time between false alarms on healthy records [s]; null if there was no alarm."""

    interval: tuple[float, float | None]
    """Confidence interval of the mean time [s]; null if there is no upper bound."""

    hours: float
    """Hours of healthy operation in the training data."""

    rests_on: Literal["pieces", "records", "groups"] = "records"
    """Resampled units: groups, records, or pieces of records if there are few records."""


class ChannelRange(Section):
    """Range of a channel in healthy windows, widened by a margin; a window outside it is novel."""

    low: tuple[float, float]
    """Range of the 1 % quantile."""

    high: tuple[float, float]
    """Range of the 99 % quantile."""

    activity: tuple[float, float]
    """Range of the RMS of differences between adjacent samples."""

    at_end: float = Field(ge=0.0, le=1.0)
    """Largest fraction of samples at the lowest or at the highest value; above it a window is clipped."""


class DetectorFile(Section):
    """A trained detector."""

    schema_name: Literal["hydrofdi.detector"] = Field(default="hydrofdi.detector", alias="schema")
    """Identifier of the schema."""

    version: Literal[1] = 1
    """Version of the schema."""

    units: str = "SI: s, Hz, m, V, Pa; scores in the unit below"
    """Units of all numbers in the file."""

    made: Made
    config: DetectorConfig
    """Complete configuration with all options, so that new defaults of hydrofdi have no effect."""

    assumed: tuple[str, ...] = ()
    """Plant constants that were left at their nominal values although the records are measured."""

    indicator_version: int
    """Version of the indicator; a different version gives different values and is refused."""

    unit: str
    """SI unit of the score."""

    channels: tuple[Channel, ...]
    """Channels that a window needs."""

    sampling_frequency: float = Field(ge=1e-3, le=1e9)
    """[Hz]"""

    n_sample: Count
    """Samples per window; 0 if estimates are judged."""

    basis: Basis
    healthy: Scale
    limits: Limits
    chart: ChartLimit | None = None
    ranges: dict[Channel, ChannelRange]
    """Healthy range of each channel."""

    positive: tuple[str, ...] = ()
    """Outputs that can only be positive, and are so in all healthy windows; in other windows without an alarm
    they make the window novel."""

    fits: dict[str, float] = Field(default_factory=dict)
    """Output that states how well the model explains a window → largest value without a doubt: that of the
    indicator, or the largest of the healthy windows if that is larger."""

    drive: tuple[float, float] | None = None
    """Lowest and highest value of the channel whose edges start cycles."""
