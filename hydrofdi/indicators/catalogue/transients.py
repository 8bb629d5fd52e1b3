"""After the steps of the drive: decay in a band (envelope), and deviation from the trend (post_step_ac)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.catalogue.ring_down import less_polynomials, orthonormal_polynomials
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import (
    Band,
    SingleChannelIndicator,
    SteppedChannelOptions,
    band_obstacle,
    middle_band,
)
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms import root_mean_square

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
