"""A limit on the newest scores, nothing more."""

from __future__ import annotations

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
    """What is taken of them."""


class MovingWindow(Chart[MovingWindowOptions]):
    """The mean or the largest of the newest scores; NaN until the window is full."""

    name = "moving_window"
    summary = "The mean or the maximum of the newest scores: the plain threshold that others have to beat."
    source = "Shewhart, Economic Control of Quality of Manufactured Product (1931); Lai (1995), see glr"
    equation = "statistic |mean of the n newest x|, or max of |x|"
    caution = "It is blind until the window is full, and again after each alarm."
    Options = MovingWindowOptions

    @property
    def n_memory(self) -> int:
        """How many scores there are, where the next one goes, and the scores."""
        return 2 + self.options.window

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """The window of each stream."""
        is_mean = self.options.measure == "mean"
        _moving_window(scores, memory, statistic, limit, is_two_sided, is_mean)


@kernel
def _moving_window(
    scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool, is_mean: bool
) -> None:
    window = memory.shape[1] - 2
    for stream in range(scores.shape[0]):
        count, place = int(memory[stream, 0]), int(memory[stream, 1])
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            statistic[stream, instant] = float("nan")
            if score != score:
                continue
            memory[stream, 2 + place] = -score if score < 0.0 and is_two_sided and not is_mean else score
            count = count + 1 if count < window else window
            place = place + 1 if place + 1 < window else 0
            if count < window:
                continue
            total, largest = 0.0, memory[stream, 2]
            for newest in range(window):
                kept = memory[stream, 2 + newest]
                total += kept
                largest = kept if kept > largest else largest
            mean = -total / window if total < 0.0 and is_two_sided else total / window
            statistic[stream, instant] = mean if is_mean else largest
            if statistic[stream, instant] >= limit:
                count = 0
        memory[stream, 0], memory[stream, 1] = count, place
