"""Exponentially weighted moving averages, scaled by their standard deviation."""

from __future__ import annotations

from typing import Annotated, Literal

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts.contract import Chart, ChartOptions
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import SI


class EwmaOptions(ChartOptions):
    """Options of `Ewma`."""

    weight: Annotated[float, SI("1", above=0, most=1)] = 0.1
    """Weight λ of the newest score [-]; the memory is about 1/λ scores."""

    variance: Literal["exact", "limiting"] = "exact"
    """Variance of the average: ``exact`` for the time since the start, or its limit (``limiting``)."""


class Ewma(Chart[EwmaOptions]):
    """Exponentially weighted mean over its standard deviation for independent scores."""

    name = "ewma"
    summary = (
        "Exponentially weighted mean over its standard deviation; for changes of up to about one spread."
    )
    source = "Roberts, Technometrics 1 (1959) 239; Lucas and Saccucci, Technometrics 32 (1990) 1"
    equation = "z ← (1 − λ) z + λ x, statistic |z|/σ, σ² = λ/(2 − λ) (1 − (1 − λ)²ᵗ)"
    caution = "With dependent scores the spread of the mean exceeds σ: set the limit from records."
    Options = EwmaOptions

    @property
    def n_memory(self) -> int:
        """Two: the mean, and its variance relative to the limiting one."""
        return 2

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Update the mean of each stream."""
        is_exact = self.options.variance == "exact"
        _ewma(scores, memory, statistic, limit, is_two_sided, self.options.weight, is_exact)


@kernel
def _ewma(
    scores: Array,
    memory: Array,
    statistic: Array,
    limit: float,
    is_two_sided: bool,
    weight: float,
    is_exact: bool,
) -> None:
    kept = (1.0 - weight) * (1.0 - weight)
    limiting = weight / (2.0 - weight)
    for stream in range(scores.shape[0]):
        mean, settled = memory[stream, 0], memory[stream, 1]
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            if score != score:
                statistic[stream, instant] = score
                continue
            mean = (1.0 - weight) * mean + weight * score
            settled = kept * settled + (1.0 - kept)
            variance = limiting * settled if is_exact else limiting
            size = mean / variance**0.5
            if is_two_sided and size < 0.0:
                size = -size
            statistic[stream, instant] = size
            if size >= limit:
                mean = settled = 0.0
        memory[stream, 0], memory[stream, 1] = mean, settled
