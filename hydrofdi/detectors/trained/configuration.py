"""Configuration of a detector before training: indicator, windows, false-alarm rate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field

from hydrofdi.evaluation.direction import Direction
from hydrofdi.records.channels import Channel
from hydrofdi.records.streams import Windower, make_windower
from hydrofdi.settings.quantities import SI, Section

Duration = Annotated[float, SI("s", least=1e-9, most=1e9)]
Share = Annotated[float, SI("1", least=1e-9, most=0.5)]


class WindowConfig(Section):
    """Division of streams and long records into windows, which are judged one at a time."""

    by: Literal["time", "cycle", "estimate"] = "time"
    """``time``: windows of equal duration. ``cycle``: one window from each edge of the drive. ``estimate``: a
    recursive indicator follows the stream without windows, and each of its estimates is judged."""

    duration: Duration | None = None
    """Duration of a window [s]; by default that of the healthy records. Cycles are truncated to it; shorter
    ones are not judged."""

    every: Duration | None = None
    """Time between the starts of adjacent windows [s]; by default the duration. Windows overlap if it is
    shorter."""

    channel: Channel = Channel.INPUT_VOLTAGE
    """Channel whose edges start a cycle."""

    edge: Literal["rising", "falling", "both"] = "rising"
    """Edges that start a cycle. An edge is where the channel crosses the middle of its range in healthy
    records."""

    def n_every(self, n_sample: int, sampling_frequency: float) -> int:
        """Samples from the start of one window to the start of the next; cycles do not overlap."""
        if self.every is None or self.by == "cycle":
            return n_sample
        return max(1, round(self.every * sampling_frequency))

    def windower(
        self,
        n_sample: int,
        channels: Sequence[Channel],
        sampling_frequency: float,
        drive: tuple[float, float] | None,
    ) -> Windower:
        """The windower of a stream with these windows, not of estimates."""
        return make_windower(
            "cycle" if self.by == "cycle" else "time",
            n_sample,
            self.n_every(n_sample, sampling_frequency),
            channels=channels,
            sampling_frequency=sampling_frequency,
            drive_channel=self.channel,
            drive=drive,
            edge=self.edge,
        )


class ChartConfig(Section):
    """A control chart on the scores."""

    chart: str
    """Name of the chart, such as ``cusum`` or ``ewma``."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the chart."""

    false_alarm_every: Duration = 86400.0
    """Required mean time between false alarms [s]."""


class DetectorConfig(Section):
    """Configuration of a detector before training."""

    indicator: str = "dwt"
    """Name of an indicator."""

    options: dict[str, Any] = Field(default_factory=dict)
    """Options of the indicator."""

    output: str = ""
    """Output that is the score; by default the first one that is a score."""

    direction: Direction | None = None
    """Direction of change that raises an alarm; by default that of the output."""

    false_alarm_rate: Share = 0.01
    """Fraction of healthy windows that raise an alarm."""

    confidence: Annotated[float, SI("1", least=0.5, most=0.9999)] = 0.95
    """Confidence level of intervals."""

    threshold: Literal["quantile", "tolerance"] = "quantile"
    """``quantile``: meets the rate on average. ``tolerance``: meets it with the given confidence."""

    window: WindowConfig = WindowConfig()
    """Division of streams and long records into windows."""

    accept: bool = False
    """Whether to train although estimates are physically impossible in most healthy windows."""

    chart: ChartConfig | None = None
    """Control chart on the scores; by default only the threshold is used."""
