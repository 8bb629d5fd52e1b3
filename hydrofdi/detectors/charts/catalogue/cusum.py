"""Cumulative sums, for small persistent changes."""

from __future__ import annotations

from typing import Annotated

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts.contract import Chart, ChartOptions
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import SI


class CusumOptions(ChartOptions):
    """Options of `Cusum`."""

    shift: Annotated[float, SI("1", above=0)] = 1.0
    """Change of the mean that is detected fastest, in healthy standard deviations [-]; k is half of it."""


class Cusum(Chart[CusumOptions]):
    """Page's cumulative sum with reference value k, two-sided unless a direction is chosen."""

    name = "cusum"
    summary = (
        "Accumulates the excess of the scores over half the expected change; optimal for a change of that"
        " size."
    )
    source = "Page, Biometrika 41 (1954) 100; Lorden, Annals of Mathematical Statistics 42 (1971) 1897"
    equation = "C⁺ ← max(0, C⁺ + x − k), C⁻ ← max(0, C⁻ − x − k), statistic max(C⁺, C⁻), k = shift/2"
    caution = "Healthy records with a mean above k accumulate like a leak: use a larger shift."
    Options = CusumOptions

    @property
    def n_memory(self) -> int:
        """Two: one sum per direction."""
        return 2

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Update both sums of each stream."""
        _cusum(scores, memory, statistic, limit, is_two_sided, self.options.shift / 2.0)


@kernel
def _cusum(
    scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool, reference: float
) -> None:
    for stream in range(scores.shape[0]):
        rising, falling = memory[stream, 0], memory[stream, 1]
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            if score != score:
                statistic[stream, instant] = score
                continue
            rising += score - reference
            if rising < 0.0:
                rising = 0.0
            if is_two_sided:
                falling -= score + reference
                if falling < 0.0:
                    falling = 0.0
            largest = rising if rising > falling else falling
            statistic[stream, instant] = largest
            if largest >= limit:
                rising = falling = 0.0
        memory[stream, 0], memory[stream, 1] = rising, falling
