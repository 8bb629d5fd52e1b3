"""Generalised likelihood ratio, for a change of unknown size at an unknown instant."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts.contract import Chart, ChartOptions
from hydrofdi.evaluation.scores import Array


class GlrOptions(ChartOptions):
    """Options of `Glr`."""

    window: Annotated[int, Field(ge=1)] = 100
    """Number of newest scores searched for a change."""


class Glr(Chart[GlrOptions]):
    """Log-likelihood ratio of the best change of the mean within the window against no change."""

    name = "glr"
    summary = "Most likely change of the mean, of any size and at any instant within a window."
    source = (
        "Willsky and Jones, IEEE Trans. Automatic Control 21 (1976) 108;"
        " Lai, Journal of the Royal Statistical Society B 57 (1995) 613"
    )
    equation = "statistic max over j ≤ window of S²/(2 j), S the sum of the j newest scores"
    caution = "Changes before the window are not detected; the cost grows with the window."
    Options = GlrOptions

    @property
    def n_memory(self) -> int:
        """The newest scores, padded with zeros, which do not change the largest ratio."""
        return self.options.window

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Update the ratio of each stream."""
        _glr(scores, memory, statistic, limit, is_two_sided)


@kernel
def _glr(scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool) -> None:
    for stream in range(scores.shape[0]):
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            if score != score:
                statistic[stream, instant] = score
                continue
            total, largest = 0.0, 0.0
            for length in range(1, memory.shape[1] + 1):
                earlier = memory[stream, length - 1]
                memory[stream, length - 1] = score
                total += score
                size = abs(total)
                ratio = size * (size if is_two_sided else total) / (2.0 * length)
                largest = ratio if ratio > largest else largest
                score = earlier
            statistic[stream, instant] = largest
            if largest >= limit:
                for place in range(memory.shape[1]):
                    memory[stream, place] = 0.0
