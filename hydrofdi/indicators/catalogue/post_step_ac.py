"""Deviation of a pressure from its trend after each step of the drive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import numpy as np
from pydantic import Field

from hydrofdi.evaluation.scores import Direction
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.single_channel import SingleChannelIndicator, SteppedChannelOptions
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.quantities import SI
from hydrofdi.transforms.free_motion import less_polynomials, orthonormal_polynomials


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
