"""After the steps of the drive: decay in a band (envelope), and deviation from the trend (post_step_ac)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.catalogue.spectra import Band, band_obstacle, middle_band
from hydrofdi.indicators.contract import ChannelOptions, Output, SingleChannelIndicator
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import ABOVE, SI, Section
from hydrofdi.transforms import root_mean_square

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
    asked, period, frequency = options.steps, records.drive_period, records.sampling_frequency
    if asked == "command" or (asked == "auto" and Channel.INPUT_VOLTAGE in records.channels):
        return jumps(records[Channel.INPUT_VOLTAGE], lag, spacing, _LEAST_RATIO, options.least_jump)
    if asked in ("auto", "period") and period is not None:
        return half_periods(records.n_record, records.n_time, frequency, period, records.start_time)
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


_EDGE = 0.375
"""Width of each transition of the gain, as a fraction of the band; a sharper edge would ring longer."""


def analytic_signal(
    signal: Array, sampling_frequency: float, band: tuple[float, float]
) -> NDArray[np.complex128]:
    """Zero-delay analytic signal (..., n_time) of a band [Hz]; records are treated as periodic.

    The real part is the band-pass signal, with raised-cosine transitions of the gain, the imaginary part its
    Hilbert transform.
    """
    n_time = signal.shape[-1]
    gain = _gain(np.arange(n_time // 2 + 1) * (sampling_frequency / n_time), band)
    # Without negative frequencies and with twice the others, the imaginary part is the Hilbert transform.
    analytic: NDArray[np.complex128] = np.fft.ifft(2.0 * gain * np.fft.rfft(signal, axis=-1), n_time, axis=-1)
    return analytic


def _gain(frequency: Array, band: tuple[float, float]) -> Array:
    low, high = band
    # Distance from the nearer end of the band, in widths of a transition.
    inside = np.minimum(frequency - low, high - frequency) / (_EDGE * (high - low))
    gain: Array = np.sin(0.5 * np.pi * np.clip(inside, 0.0, 1.0)) ** 2
    return gain


_FEWEST_SAMPLES = 8
_ROUNDING = 1e-12
"""Envelope relative to the largest sample below which there is only rounding error."""


class EnvelopeOptions(SteppedChannelOptions):
    """Options of `Envelope`."""

    band: Band | None = None
    """Band whose envelope is taken [Hz]; by default a sixteenth to a quarter of the sampling frequency."""

    delay: Annotated[float, SI("s", least=0)] = 30e-3
    """Time excluded after a step [s]: the band-pass filter smears the step."""

    window: Annotated[float, SI("s", above=0)] = 0.1
    """Time that the decay is fitted to after each step [s]."""


class Envelope(SingleChannelIndicator[EnvelopeOptions]):
    """RMS of the envelope of a band, and its rate of decay after steps of the drive."""

    name = "envelope"
    version = 1
    source = "Feldman, Hilbert Transform Applications in Mechanical Vibration (2011)"
    equation = "A(t) = |x + i H x| in the band; ln A = c − σ t by least squares weighted by A²"
    caution = (
        "The band-pass gain has transitions over three eighths of the band at each side, so a frequency "
        "shift within the band changes the amplitude. Heavy damping biases the rate of decay downwards."
    )
    Options = EnvelopeOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Amplitude over the record, and decay over its steps."""
        return (
            Output("amplitude", self.unit, "RMS of the envelope"),
            Output(
                "decay_rate",
                "1/s",
                "rate of decay σ of the envelope, mean over the steps",
                direction=Direction.RISING,
            ),
            Output.quality(
                "decay_rate_spread",
                "1/s",
                "standard deviation of σ over the steps, if there are at least two",
            ),
            Output.quality("steps", "1", "number of steps with a fitted decay"),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if a band or window does not fit the records, or the steps cannot be found."""
        band = middle_band(self.options.band, records.sampling_frequency)
        if band[1] - band[0] < 4.0 / records.duration - 1e-9:
            return f"a band of {band[1] - band[0]:g} Hz needs records of {4.0 / (band[1] - band[0]):.3g} s"
        return band_obstacle(records, band) or self.options.obstacle(records, _FEWEST_SAMPLES)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); the decay is NaN if no step is followed by a full window."""
        signal, sampling = self.signal(records), records.sampling_frequency
        envelope = np.abs(analytic_signal(signal, sampling, middle_band(self.options.band, sampling)))
        steps = self.options.steps_of(records, signal)
        windows = steps.windows(envelope, *self.options.window_samples(sampling))
        moves = windows.min(axis=1, initial=np.inf) > _ROUNDING * np.abs(signal).max(axis=1)[steps.record]
        steps, rates = steps.where(moves), _decay_rates(windows[moves], sampling)
        count = steps.counts(records.n_record).astype(float)
        mean, squares = steps.spread(rates, records.n_record)
        spread = np.where(count > 1.0, np.sqrt(squares / count), np.nan)
        return {
            "amplitude": root_mean_square(envelope),
            "decay_rate": mean,
            "decay_rate_spread": spread,
            "steps": count,
        }


def _decay_rates(envelopes: Array, sampling_frequency: float) -> Array:
    """Decay rates of windows (n_step, n_time) [1/s]; larger values have larger weights."""
    time = np.arange(envelopes.shape[1]) / sampling_frequency
    # Noise of ln A grows as 1/A, so the weight of least squares is A².
    weight = np.square(envelopes)
    weight /= weight.sum(axis=1, keepdims=True)
    apart = time - np.sum(weight * time, axis=1, keepdims=True)
    rates: Array = -np.sum(weight * apart * np.log(envelopes), axis=1) / np.sum(weight * apart**2, axis=1)
    return rates


def orthonormal_polynomials(n_time: int, degree: int) -> Array:
    """Polynomials up to a degree, orthonormal on the sample grid, shape (degree + 1, n_time)."""
    powers = np.vander(np.linspace(-1.0, 1.0, n_time), degree + 1, increasing=True)
    return np.ascontiguousarray(np.linalg.qr(powers)[0].T)


def less_polynomials(pieces: Array, polynomials: Array) -> Array:
    """Pieces of a signal (n_piece, n_time) minus their trend of orthonormal polynomials.

    They are contiguous, so that the bits of a piece do not depend on the other pieces.
    """
    for polynomial in polynomials:
        pieces = pieces - np.sum(pieces * polynomial, axis=1)[:, None] * polynomial
    return pieces


class PostStepAcOptions(SteppedChannelOptions):
    """Options of `PostStepAc`."""

    delay: Annotated[float, SI("s", least=0)] = 0.0
    """Time excluded after a step [s]."""

    window: Annotated[float, SI("s", above=0)] = 0.25
    """Time analysed after each step [s]."""

    trend_degree: Annotated[int, Field(strict=True, ge=0, le=6)] = 3
    """Degree of the subtracted polynomial."""


class PostStepAc(SingleChannelIndicator[PostStepAcOptions]):
    """RMS of the pressure about its trend after the steps of the drive, absolute and relative to its
    level.
    """

    name = "post_step_ac"
    version = 1
    source = (
        "a choice of hydrofdi; Goharrizi and Sepehri, IEEE Trans. Ind. Electron. (2010), analyse transients"
        " after steps"
    )
    equation = "mean over the steps of sqrt(mean((P − cubic)²)), and of its ratio to the mean of P"
    absence = "no step of the drive is followed by a full window"
    Options = PostStepAcOptions

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Means over the steps."""
        return (
            Output("rms", self.unit, "RMS about the trend, mean over the steps", direction=Direction.FALLING),
            Output.quality(
                "rms_error", self.unit, "standard error of the RMS from its spread over the steps"
            ),
            Output(
                "relative",
                "1",
                "RMS relative to the mean level in the window, mean over the steps",
                direction=Direction.FALLING,
            ),
        )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the steps cannot be found, or if the polynomial fits any window exactly."""
        return self.options.obstacle(records, self.options.trend_degree + 2)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,), in the unit of the channel; NaN if no step is followed by a full window."""
        signal, n_record = self.signal(records), records.n_record
        window = self.options.window_samples(records.sampling_frequency)
        steps = self.options.steps_of(records, signal)
        pieces, count = steps.windows(signal, *window), steps.counts(n_record)
        trend = orthonormal_polynomials(window[1], self.options.trend_degree)
        rms = np.sqrt(np.mean(np.square(less_polynomials(pieces, trend)), axis=1))
        mean, spread = steps.spread(rms, n_record)
        relative = steps.sums(rms / pieces.mean(axis=1), n_record) / count
        return {"rms": mean, "rms_error": np.sqrt(spread / ((count - 1.0) * count)), "relative": relative}
