"""The ``record`` section: how long, how finely, and how often sampled."""

from __future__ import annotations

import math
import sys
from typing import Annotated, Self

from pydantic import model_validator

from hydrofdi.settings.quantities import SI, Section


def is_whole(ratio: float) -> bool:
    """Whether a ratio is an integer from 1 on, up to rounding."""
    return math.isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) < 1e-6


_MOST_SAMPLES, _MOST_STEPS_PER_SAMPLE = 10_000_000, 1_000_000
"""What a record may hold so that it fits into memory."""


class RecordConfig(Section):
    """Integration and sampling of a record."""

    duration: Annotated[float, SI("s", above=0, usual=("10 ms", "24 h"))] = 20.0
    """Length of the record [s]."""

    step: Annotated[float, SI("s", above=0, usual=("0.1 µs", "10 ms"))] = 1e-4
    """Runge-Kutta step [s]. Legible as ".1 seconds", read as 0.1 ms: 1 ms is unstable in the friction's
    linear zone."""

    sampling_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "1 MHz"))] = 500.0
    """Sampling frequency of the record [Hz]. Caption of Figure 2, legible as "5"; 250 Hz is admissible."""

    @model_validator(mode="after")
    def _times_fit_the_step(self) -> Self:
        ratio = self.sampling_frequency * self.step
        if ratio < sys.float_info.min or not is_whole(1.0 / ratio):
            raise ValueError(
                f"the sampling interval 1/sampling_frequency = {1 / self.sampling_frequency:g} s"
                f" is not a multiple of step = {self.step:g} s"
            )
        if not is_whole(self.duration * self.sampling_frequency):
            raise ValueError(f"duration = {self.duration:g} s is not a multiple of the sampling interval")
        if self.n_sample > _MOST_SAMPLES or self.steps_per_sample > _MOST_STEPS_PER_SAMPLE:
            raise ValueError(
                f"{self.n_sample:.3g} samples with {self.steps_per_sample:.3g} steps each are too many;"
                f" at most {_MOST_SAMPLES:g} and {_MOST_STEPS_PER_SAMPLE:g}"
            )
        return self

    @property
    def n_step(self) -> int:
        """Number of Runge-Kutta steps."""
        return self.n_sample * self.steps_per_sample

    @property
    def n_sample(self) -> int:
        """Number of samples t_k = k/f_s, k = 0 … n_sample − 1."""
        return round(self.duration * self.sampling_frequency)

    @property
    def time_axis(self) -> tuple[float, float, float]:
        """Duration [s], step [s] and sampling frequency [Hz]."""
        return self.duration, self.step, self.sampling_frequency

    @property
    def steps_per_sample(self) -> int:
        """Number of Runge-Kutta steps from one sample to the next."""
        return round(1.0 / (self.sampling_frequency * self.step))
