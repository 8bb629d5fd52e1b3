"""The ``run`` section: how long, how finely, and how often sampled."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass
from typing import Annotated, Any, Self

from pydantic import GetCoreSchemaHandler, model_validator
from pydantic_core import CoreSchema, core_schema

from hydrofdi.settings.quantities import SI, Section


def is_whole(ratio: float) -> bool:
    """Whether a ratio is a whole number from 1 on, up to rounding."""
    return math.isfinite(ratio) and round(ratio) >= 1 and abs(ratio - round(ratio)) < 1e-6


_MOST_SAMPLES, _MOST_STEPS_PER_SAMPLE = 10_000_000, 1_000_000
"""What a record may hold so that it fits into memory."""


_PERIODS = re.compile(r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*periods?\s*")


@dataclass(frozen=True)
class TimeOrPeriods(SI):
    """Annotation of a time from zero on [s], or of a number of periods, held as a text like ``2 periods``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse, and check a time's limit."""
        return core_schema.no_info_plain_validator_function(self._time_or_periods)

    def _time_or_periods(self, value: Any) -> float | str:
        periods = _PERIODS.fullmatch(value) if isinstance(value, str) else None
        if periods is not None:
            number = float(periods[1])
            return f"{number:.15g} {'period' if number == 1.0 else 'periods'}"
        if isinstance(value, str) and value.rstrip().endswith(("period", "periods")):
            raise ValueError(f"must be a number of periods from zero on, such as '1 period'; found {value!r}")
        time = self.parse(value)
        if not 0.0 <= time < math.inf:
            raise ValueError(f"must be a time from zero on; found {value}")
        return time


class RunConfig(Section):
    """Integration and sampling of one run."""

    duration: Annotated[float, SI("s", above=0, usual=("10 ms", "24 h"))] = 20.0
    """Length of the record [s]."""

    step: Annotated[float, SI("s", above=0, usual=("0.1 µs", "10 ms"))] = 1e-4
    """Runge-Kutta step [s]. Legible as ".1 seconds", read as 0.1 ms: 1 ms is unstable in the friction's
    linear zone."""

    sampling_frequency: Annotated[float, SI("Hz", above=0, usual=("1 Hz", "1 MHz"))] = 500.0
    """Sampling frequency of the record [Hz]. Caption of Figure 2, legible as "5"; 250 Hz is admissible."""

    discard: Annotated[float | str, TimeOrPeriods("s", least=0)] = 0.0
    """Start of the record that the features leave out: a time [s], or periods of the input such as
    ``1 period``, whatever ``input.period`` is in a run. Signals keep it, and so do the numbers of the plant
    itself: leakage flows, extremes, hydraulic mode."""

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
        if isinstance(self.discard, float):
            require_whole_discard(self.discard, f"{self.discard:g} s", self)
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
    def without_discard(self) -> RunConfig:
        """The same record with nothing left out."""
        return RunConfig.model_validate(self.model_dump() | {"discard": 0.0}) if self.discard else self

    @property
    def discards_periods(self) -> bool:
        """Whether what is left out is stated in periods of the input."""
        return isinstance(self.discard, str)

    def discarded_time(self, period: float) -> float:
        """Start of the record that the features leave out, for an input of some period [s]."""
        if isinstance(self.discard, str):
            return float(self.discard.split()[0]) * period
        return self.discard

    @property
    def steps_per_sample(self) -> int:
        """Number of Runge-Kutta steps from one sample to the next."""
        return round(1.0 / (self.sampling_frequency * self.step))


def require_whole_discard(time: float, shown: str, run: RunConfig) -> None:
    """Check that what a record leaves out is a whole number of samples, and less than all.

    Raises
    ------
    ValueError
        It is not.
    """
    if time and not is_whole(time * run.sampling_frequency):
        raise ValueError(f"discard = {shown} is not a multiple of the sampling interval")
    if time >= run.duration:
        raise ValueError(f"discard = {shown} leaves nothing of duration = {run.duration:g} s")
