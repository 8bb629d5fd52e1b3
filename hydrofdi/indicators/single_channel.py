"""Indicators of one channel: in frequency bands, and after the steps of the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator

from hydrofdi.indicators.contract import Indicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI, Section
from hydrofdi.units import ABOVE

_FEWEST_SAMPLES = 8
"""Least number of samples of a segment."""


def _rising(band: tuple[float, float]) -> tuple[float, float]:
    if not band[0] < band[1]:
        raise ValueError(f"a band must be [lowest, highest] frequency; found {list(band)} Hz")
    return band


Frequency = Annotated[float, SI("Hz", least=0)]
"""[Hz]"""

Band = Annotated[tuple[Frequency, Frequency], AfterValidator(_rising)]
"""Lowest and highest frequency [Hz]."""

SegmentTime = Annotated[float, SI("s", above=0)]
"""Length of a segment [s]."""


def middle_band(band: Band | None, sampling_frequency: float) -> Band:
    """The band, by default from 1/16 to 1/4 of the sampling frequency [Hz]."""
    return (sampling_frequency / 16, sampling_frequency / 4) if band is None else band


def band_obstacle(records: RecordBatch, band: Band) -> str | None:
    """Message if the band ends above half of the sampling frequency, else None."""
    highest = records.sampling_frequency / 2
    if band[1] > highest:
        return f"a band ends at {band[1]:g} Hz, above half of the sampling frequency, {highest:g} Hz"
    return None


def segment_obstacle(records: RecordBatch, segment: float) -> str | None:
    """Message if the segment is longer than the record or has too few samples, else None."""
    samples = round(segment * records.sampling_frequency)
    if samples < _FEWEST_SAMPLES:
        return f"a segment of {segment:g} s has {samples} samples; {_FEWEST_SAMPLES} are needed"
    if samples > records.n_time:
        return f"a segment of {segment:g} s has {samples} samples, but the record only {records.n_time}"
    return None


class ChannelOptions(Section):
    """Options of an indicator of one channel."""

    channel: Channel = Channel.CHAMBER_1_PRESSURE
    """Channel to measure."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The measured channel."""
        return frozenset({self.channel})


ChosenChannel = TypeVar("ChosenChannel", bound=ChannelOptions)


class SingleChannelIndicator(Indicator[ChosenChannel]):
    """An indicator that needs one channel, which its options name."""

    @property
    def unit(self) -> str:
        """Unit of the channel."""
        return self.options.channel.unit

    def signal(self, records: RecordBatch) -> Array:
        """Samples of the channel, shape (n_record, n_time)."""
        return records[self.options.channel]


Places = NDArray[np.intp]


@dataclass(frozen=True)
class Steps:
    """Steps of the drive in a batch, sorted by record and time: row, and first sample after the step."""

    record: Places
    sample: Places

    def where(self, chosen: NDArray[np.bool_]) -> Steps:
        """Subset of the steps."""
        return Steps(self.record[chosen], self.sample[chosen])

    def with_window(self, first: int, length: int, n_time: int) -> Steps:
        """Steps whose window ends before the next step and before the end of the record.

        The window has `length` samples and starts `first` samples after the step.
        """
        is_last = np.append(np.diff(self.record) != 0, True)[: self.record.size]
        stop = np.where(is_last, n_time, np.append(self.sample[1:], n_time)[: self.sample.size])
        return self.where(self.sample + first + length <= stop)

    def windows(self, signal: Array, first: int, length: int) -> Array:
        """Samples of a signal (n_record, n_time) in the window after each step, shape (n_step, length)."""
        starts = self.sample + first
        windows: Array = signal[self.record[:, None], starts[:, None] + np.arange(length)]
        return windows

    def spread(self, values: Array, n_record: int) -> tuple[Array, Array]:
        """Mean of values (n_step,) over the steps of each record, and the sum of squares about it, each
        (n_record,)."""
        mean = self.sums(values, n_record) / self.counts(n_record)
        return mean, self.sums(np.square(values - mean[self.record]), n_record)

    def sums(self, values: Array, n_record: int) -> Array:
        """Sum of values (n_step,) over the steps of each record, shape (n_record,)."""
        return np.bincount(self.record, values, n_record).astype(np.float64)

    def counts(self, n_record: int) -> Places:
        """Number of steps of each record, shape (n_record,)."""
        counts: Places = np.bincount(self.record, minlength=n_record)
        return counts


def jumps(signal: Array, lag: int, spacing: int, least_ratio: float = 0.0, least_share: float = 0.5) -> Steps:
    """Find jumps: changes within `lag` samples that exceed a fraction of the largest such change.

    Those closer than `spacing` samples to another one belong to it. If the ratio of largest to mean change is
    below `least_ratio`, a record has no jumps; this separates square waves from noise.
    """
    n_change = max(signal.shape[1] - lag, 0)
    change = signal[:, lag:] - signal[:, :n_change]
    np.abs(change, out=change)
    largest = change.max(axis=1, initial=0.0)
    is_jumping = np.isfinite(largest) & (largest * n_change > least_ratio * change.sum(axis=1))
    least = np.where(is_jumping, ABOVE * least_share * largest, np.inf)
    record, first = np.divmod(np.flatnonzero(change > least[:, None]), max(n_change, 1))
    apart = (np.diff(first, prepend=-1) > spacing) | (np.diff(record, prepend=-1) != 0)
    return Steps(record[apart], first[apart] + lag)


def half_periods(
    n_record: int, n_time: int, sampling_frequency: float, period: float, start_time: float = 0.0
) -> Steps:
    """Middles and ends of the periods of a drive that started at time zero, the same in each record."""
    # a thousandth of a sample, also where clocks count from 1970
    half, rounding = period / 2.0, 2e-3 / (period * sampling_frequency)
    first = math.floor(start_time / half + rounding) + 1
    last = math.floor((start_time + (n_time - 1) / sampling_frequency) / half + rounding)
    instants = half * np.arange(first, last + 1) - start_time
    sample = np.ceil(instants * sampling_frequency - 1e-3).astype(np.intp)
    return Steps(np.repeat(np.arange(n_record), sample.size), np.tile(sample, n_record))


_LEAST_RATIO = 8.0
"""Least ratio of largest to mean change of a command with steps; noise stays below it."""


class SteppingOptions(Section):
    """Options that define the steps of the drive."""

    steps: Literal["auto", "command", "period", "signal"] = "auto"
    """``command``: the jumps of the input voltage. ``period``: every half period of the drive. ``signal``:
    the largest changes of the signal itself. ``auto``: the first of these that is available."""

    jump_time: Annotated[float, SI("s", above=0)] = 10e-3
    """Longest duration of a jump [s]; its instant is where it exceeds ``least_jump``."""

    least_jump: Annotated[float, SI("1", above=0, most=1)] = 0.5
    """Smallest jump relative to the largest in the record [-]; smaller ones are ignored."""

    spacing: Annotated[float, SI("s", above=0)] = 0.1
    """Jumps that follow another within this time count as part of it [s]."""


class SteppedChannelOptions(ChannelOptions, SteppingOptions):
    """Options of an indicator of one channel in a window after each step of the drive.

    Subclasses state ``delay`` and ``window``: the time excluded after a step and the time analysed [s].
    """

    if TYPE_CHECKING:
        delay: float
        window: float

    def window_samples(self, sampling_frequency: float) -> tuple[int, int]:
        """Samples that are excluded after a step, and samples of the window."""
        return round(self.delay * sampling_frequency), round(self.window * sampling_frequency)

    def obstacle(self, records: RecordBatch, n_least: int) -> str | None:
        """Message if the steps cannot be found, or the window has too few samples; else None."""
        n_sample = self.window_samples(records.sampling_frequency)[1]
        if n_sample < n_least:
            return f"a window of {self.window:g} s has {n_sample} samples; {n_least} are needed"
        if self.steps == "period" and records.drive_period is None:
            return "the period of the drive is unknown"
        return None

    def steps_of(self, records: RecordBatch, signal: Array) -> Steps:
        """The steps that are followed by a full window."""
        window = self.window_samples(records.sampling_frequency)
        return drive_steps(records, self, signal).with_window(*window, records.n_time)

    @property
    def channels(self) -> frozenset[Channel]:
        """The channel, and the voltage if it shows the steps."""
        return super().channels | ({Channel.INPUT_VOLTAGE} if self.steps == "command" else set())

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """The voltage, if it may show the steps."""
        return frozenset({Channel.INPUT_VOLTAGE} if self.steps == "auto" else ())


def drive_steps(records: RecordBatch, options: SteppingOptions, signal: Array) -> Steps:
    """The steps of the drive after the first sample of each record.

    They are those of the `signal` (n_record, n_time) if there is neither a command nor a period.
    """
    lag, spacing = (
        max(1, round(time * records.sampling_frequency)) for time in (options.jump_time, options.spacing)
    )
    match _shown_by(records, options):
        case "command":
            return jumps(records[Channel.INPUT_VOLTAGE], lag, spacing, _LEAST_RATIO, options.least_jump)
        case "period" if records.drive_period is not None:
            return half_periods(
                records.n_record,
                records.n_time,
                records.sampling_frequency,
                records.drive_period,
                records.start_time,
            )
    return jumps(signal, lag, spacing, least_share=options.least_jump)


def alternating_side(records: RecordBatch, signal: Array) -> Array:
    """Alternating sign of a drive that is not measured, from step to step, shape (n_record, n_time).

    It is +1 after a step at which the signal rises, e.g. the pressure of the supplied chamber.
    """
    steps = drive_steps(records, SteppingOptions(), signal)
    turns = np.zeros(signal.shape, dtype=int)
    turns[steps.record, steps.sample] = 1
    side = 1.0 - 2.0 * (np.cumsum(turns, axis=1) % 2)
    rise = np.sum(side[:, :-1] * np.diff(signal, axis=1), axis=1, keepdims=True)
    return side * np.where(rise < 0.0, -1.0, 1.0)


def _shown_by(records: RecordBatch, options: SteppingOptions) -> str:
    if options.steps != "auto":
        return options.steps
    if Channel.INPUT_VOLTAGE in records.channels:
        return "command"
    return "signal" if records.drive_period is None else "period"
