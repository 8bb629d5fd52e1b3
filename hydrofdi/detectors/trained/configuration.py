"""What a detector shall be before it is trained: indicator, windows, rate of false alarms."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from hydrofdi.evaluation.direction import Direction
from hydrofdi.records.channels import Channel
from hydrofdi.settings.quantities import SI, Section

Duration = Annotated[float, SI("s", least=1e-9, most=1e9)]
Share = Annotated[float, SI("1", least=1e-9, most=0.5)]


class WindowConfig(Section):
    """How streams and long records are cut. One window is judged at a time."""

    by: Literal["time", "cycle", "estimate"] = "time"
    """``time``: windows of equal duration. ``cycle``: one from each edge of the drive. ``estimate``: a
    recursive indicator follows the stream without windows, and each of its estimates is judged."""

    duration: Duration | None = None
    """Duration of a window [s]; that of the healthy records where left out. Cycles are cut to it; shorter
    ones are not judged."""

    every: Duration | None = None
    """Time from the start of one window to the start of the next [s]; the duration where left out.
    Windows overlap where it is less."""

    channel: Channel = Channel.INPUT_VOLTAGE
    """Channel whose edges start a cycle."""

    edge: Literal["rising", "falling", "both"] = "rising"
    """Which edges start a cycle, where the channel crosses the middle of its range in healthy records."""


class ChartConfig(Section):
    """A control chart on the scores."""

    chart: str
    """Name of the chart, such as ``cusum`` or ``ewma``."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the chart."""

    false_alarm_every: Duration = 86400.0
    """Wanted mean time between false alarms [s]."""


class DetectorConfig(Section):
    """A detector before it is trained."""

    indicator: str = "dwt"
    """Name of an indicator."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the indicator."""

    output: str = ""
    """Which of its numbers is the score; the first one that is a score where left out."""

    direction: Direction | None = None
    """Which departure raises an alarm; that of the output where left out."""

    false_alarm_rate: Share = 0.01
    """Share of healthy windows that raise an alarm."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Of intervals."""

    threshold: Literal["quantile", "tolerance"] = "quantile"
    """``quantile``: keeps the rate on average. ``tolerance``: keeps it with the stated confidence."""

    window: WindowConfig = WindowConfig()
    """How streams and long records are cut."""

    chart: ChartConfig | None = None
    """A control chart on the scores; without one, the threshold alone decides."""
