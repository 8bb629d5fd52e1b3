"""The file of a trained detector: JSON that is checked when it is read. Nothing in it is executed."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.detectors.trained.configuration import DetectorConfig
from hydrofdi.records.channels import Channel
from hydrofdi.settings.quantities import Section

SCHEMA, VERSION = "hydrofdi.detector", 1

Count = Annotated[int, Field(ge=0)]


class Made(Section):
    """Who made it."""

    hydrofdi: str
    """Version of hydrofdi."""

    time: str
    """When, in UTC."""

    command: str = ""
    """The command line."""


class Basis(Section):
    """Basis of the promise."""

    sources: tuple[str, ...] = Field(min_length=1)
    """Where the healthy records came from."""

    n_record: int = Field(ge=1)
    """Healthy records."""

    n_window: int = Field(ge=1)
    """Windows of them that set the threshold; they do not overlap."""

    n_group: Count
    """Groups that do not depend on each other, such as units or days; 0 where nobody stated any."""

    populations: dict[str, Count]
    """Label of healthy records → number of their windows; empty if they have none."""

    not_judged: dict[str, Count]
    """Kind of fault → number of healthy windows that taught nothing for it."""


class Scale(Section):
    """The healthy score, in the unit of the output."""

    centre: float
    """Median."""

    spread: float = Field(gt=0.0)
    """Interquartile range over 1.349."""


class Limits(Section):
    """Limits of the score, in the unit of the output, and the rate of false alarms."""

    low: float | None
    """A score below it is an alarm; null if there is no such limit."""

    high: float | None
    """A score above it is an alarm; null if there is no such limit."""

    false_alarm_rate: float = Field(ge=1e-9, le=0.5)
    """Wanted share of healthy windows that raise an alarm."""

    interval: tuple[float, float]
    """Where the true share lies, with the confidence."""

    confidence: float = Field(ge=0.5, le=0.9999)
    """Of the interval."""

    method: str
    """How the limits were set."""

    interval_rests_on: Literal["windows", "records", "groups"]
    """``windows``: those are taken as independent. ``records``, ``groups``: each record or each group met the
    limits of the others."""


class ChartLimit(Section):
    """The limit of the control chart."""

    limit: float = Field(gt=0.0)
    """An alarm where the statistic reaches it; the chart then restarts."""

    mean_time: float | None
    """Mean time between false alarms on healthy records [s]; null if there was none."""

    interval: tuple[float, float | None]
    """Where it lies, with the confidence [s]; null if nothing bounds it."""

    hours: float
    """Hours of healthy operation that it rests on."""

    rests_on: Literal["pieces", "records", "groups"] = "records"
    """What was resampled and joined: groups, records, or pieces of records where those are few."""


class ChannelRange(Section):
    """What healthy windows showed of a channel, widened by a margin; beyond it a window is novel."""

    low: tuple[float, float]
    """Range of the 1 % quantile."""

    high: tuple[float, float]
    """Range of the 99 % quantile."""

    activity: tuple[float, float]
    """Range of the rms change from sample to sample."""

    at_end: float = Field(ge=0.0, le=1.0)
    """Largest share of samples at the lowest or at the highest value; above it a window is clipped."""


class DetectorFile(Section):
    """A trained detector."""

    schema_name: Literal["hydrofdi.detector"] = Field(default="hydrofdi.detector", alias="schema")
    """What the file is."""

    version: Literal[1] = 1
    """Version of its form."""

    units: str = "SI: s, Hz, m, V, Pa; scores in the unit below"
    """Of all numbers in the file."""

    made: Made
    config: DetectorConfig
    """In full: every option is written out, so that new defaults of hydrofdi change nothing."""

    assumed: tuple[str, ...] = ()
    """Constants of the plant among the options that nobody gave for measured records: nominal values."""

    indicator_version: int
    """Version of the indicator; another one gives other numbers, and is refused."""

    unit: str
    """SI unit of the score."""

    channels: tuple[Channel, ...]
    """Channels that a window needs."""

    sampling_frequency: float = Field(ge=1e-3, le=1e9)
    """[Hz]"""

    n_sample: Count
    """Samples of a window; 0 where estimates are judged."""

    basis: Basis
    healthy: Scale
    limits: Limits
    chart: ChartLimit | None = None
    ranges: dict[Channel, ChannelRange]
    """What is known of each channel."""

    drive: tuple[float, float] | None = None
    """Lowest and highest value of the channel whose edges start cycles."""
