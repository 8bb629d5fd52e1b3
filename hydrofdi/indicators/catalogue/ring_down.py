"""Natural frequency and damping ratio from the pressure ringing after each step of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import SingleChannelIndicator, SteppedChannelOptions, Steps
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms.free_motion import FreeMotion, fit_free_motion

_LEAST_SAMPLES = 24


class RingDownOptions(SteppedChannelOptions):
    """Options of `RingDown`."""

    less: Channel | None = None
    """Channel to subtract, such as ``chamber_2_pressure``: the difference scatters less."""

    delay: Annotated[float, SI("s", least=0)] = 10e-3
    """Time excluded after a step [s], while the valve moves."""

    window: Annotated[float, SI("s", above=0)] = 0.2
    """Time analysed after each step [s]."""

    trend_degree: Annotated[int, Field(strict=True, ge=0, le=6)] = 2
    """Degree of the polynomial trend of the pressure."""

    largest_damping: Annotated[float, SI("1", above=0, most=1)] = 0.7
    """Largest damping ratio that counts as ringing [-]; above it there is no resonance."""

    least_explained: Annotated[float, SI("1", least=0, most=1)] = 0.5
    """Fraction of the energy of the detrended pressure that the ringing must explain [-]; white noise gives
    less than 0.2."""

    @property
    def channels(self) -> frozenset[Channel]:
        """The pressures, and the input voltage if ``steps`` needs it."""
        return super().channels | (set() if self.less is None else {self.less})


class RingDown(SingleChannelIndicator[RingDownOptions]):
    """Natural frequency and damping ratio of the pressure after the steps of the drive."""

    name = "ring_down"
    version = 1
    source = "Hua and Sarkar, IEEE Trans. Acoust., Speech, Signal Process. (1990): matrix pencil"
    equation = "P = polynomial + Re(c exp(s t)) by least squares; s = 2π f_h (−ζ + i √(1 − ζ²))"
    absence = "no step of the drive is followed by a full window in which the pressure moves"
    Options = RingDownOptions

    outputs = (
        Output("frequency", "Hz", "natural frequency f_h"),
        Output.quality("frequency_error", "Hz", "standard error of f_h from the spread over the steps"),
        Output.quality(
            "frequency_formal_error", "Hz", "standard error of f_h from the residuals of the fits"
        ),
        Output("damping_ratio", "1", "damping ratio ζ", direction=Direction.RISING),
        Output.quality("damping_ratio_error", "1", "standard error of ζ from the spread over the steps"),
        Output.quality(
            "damping_ratio_formal_error", "1", "standard error of ζ from the residuals of the fits"
        ),
        Output.quality("steps", "1", "number of steps that ring"),
        Output("overdamped", "1", "fraction of steps that do not ring", direction=Direction.RISING),
    )

    def obstacle(self, records: RecordBatch) -> str | None:
        """Message if the steps cannot be found, or if a window has too few samples."""
        return self.options.obstacle(records, _LEAST_SAMPLES)

    def measure(self, records: RecordBatch) -> Mapping[str, Array]:
        """Each (n_record,); frequencies in Hz, the others dimensionless."""
        signal = self.signal(records)
        if self.options.less is not None:
            signal = signal - records[self.options.less]
        steps, pieces = self._pieces(records, signal)
        frequency = records.sampling_frequency
        motion = fit_free_motion(pieces, steps.record, frequency, self.options.trend_degree)
        return _summary(motion, steps, records.n_record, self._is_ringing(motion))

    def _pieces(self, records: RecordBatch, signal: Array) -> tuple[Steps, Array]:
        """Steps that have a full window of finite, varying pressure, and the pressure in it."""
        steps = self.options.steps_of(records, signal)
        pieces = steps.windows(signal, *self.options.window_samples(records.sampling_frequency))
        moves = np.isfinite(pieces).all(axis=1) & (np.ptp(pieces, axis=1) > 1e-9 * np.abs(pieces).max(axis=1))
        return steps.where(moves), pieces[moves]

    def _is_ringing(self, motion: FreeMotion) -> NDArray[np.bool_]:
        """Whether an oscillation with at least one period explains a piece."""
        damped = motion.frequency * np.sqrt(np.maximum(1.0 - motion.damping_ratio**2, 0.0))
        rings: NDArray[np.bool_] = damped * self.options.window >= 1.0
        rings &= motion.damping_ratio <= self.options.largest_damping
        return rings & (motion.explained >= self.options.least_explained)


def _summary(motion: FreeMotion, steps: Steps, n_record: int, rings: NDArray[np.bool_]) -> dict[str, Array]:
    ringing = steps.where(rings)
    n_step, n_ringing = steps.counts(n_record), ringing.counts(n_record).astype(float)
    values = {"steps": np.where(n_step > 0, n_ringing, np.nan), "overdamped": 1.0 - n_ringing / n_step}
    found = {
        "frequency": (motion.frequency[rings], motion.frequency_deviation[rings]),
        "damping_ratio": (motion.damping_ratio[rings], motion.damping_deviation[rings]),
    }
    for name, (of_steps, deviation) in found.items():
        values[name], spread = ringing.spread(of_steps, n_record)
        values[f"{name}_error"] = np.sqrt(spread / ((n_ringing - 1.0) * n_ringing))
        values[f"{name}_formal_error"] = np.sqrt(ringing.sums(np.square(deviation), n_record)) / n_ringing
    return values
