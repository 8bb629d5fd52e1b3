"""Limit on the mean or maximum of the newest scores."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts.contract import Chart, ChartOptions
from hydrofdi.evaluation.scores import Array


class MovingWindowOptions(ChartOptions):
    """Options of `MovingWindow`."""

    window: Annotated[int, Field(ge=1)] = 50
    """Number of newest scores."""

    measure: Literal["mean", "maximum"] = "mean"
    """Statistic of these scores."""


class MovingWindow(Chart[MovingWindowOptions]):
    """Mean or maximum of the newest scores; NaN until the window is full."""

    name = "moving_window"
    summary = "Mean or maximum of the newest scores: the simple threshold as a baseline for other charts."
    source = "Shewhart, Economic Control of Quality of Manufactured Product (1931); Lai (1995), see glr"
    equation = "statistic |mean of the n newest x|, or max of |x|"
    caution = "It cannot raise an alarm until the window is full, and again after each alarm."
    Options = MovingWindowOptions

    @property
    def n_memory(self) -> int:
        """The number of scores, and the newest ones."""
        return 1 + self.options.window

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Update the window of each stream."""
        is_mean = self.options.measure == "mean"
        _moving_window(scores, memory, statistic, limit, is_two_sided, is_mean)


@kernel
def _moving_window(
    scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool, is_mean: bool
) -> None:
    window = memory.shape[1] - 1
    for stream in range(scores.shape[0]):
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            statistic[stream, instant] = math.nan
            if score != score:
                continue
            size = -score if score < 0.0 and is_two_sided else score
            kept = score if is_mean else size
            total, largest = 0.0, kept
            for place in range(1, window + 1):
                earlier = memory[stream, place]
                memory[stream, place] = kept
                total += kept
                largest = kept if kept > largest else largest
                kept = earlier
            memory[stream, 0] += 1.0
            if memory[stream, 0] < window:
                continue
            mean = -total / window if total < 0.0 and is_two_sided else total / window
            statistic[stream, instant] = mean if is_mean else largest
            if statistic[stream, instant] >= limit:
                memory[stream, 0] = 0.0
