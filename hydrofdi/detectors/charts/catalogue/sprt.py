"""Wald's sequential probability ratio test, repeated: healthy against a known change."""

from __future__ import annotations

import math
from typing import Annotated

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts.contract import Chart, ChartOptions
from hydrofdi.evaluation.scores import Array
from hydrofdi.settings.quantities import SI


class SprtOptions(ChartOptions):
    """Options of `Sprt`."""

    shift: Annotated[float, SI("1", above=0)] = 1.0
    """Mean of the changed scores, in healthy standard deviations [-]."""

    false_alarms: Annotated[float, SI("1", above=0, most=0.5)] = 1e-3
    """False-alarm probability α of a single test of healthy scores [-]."""

    missed: Annotated[float, SI("1", above=0, most=0.5)] = 1e-2
    """Probability β that a single test of changed scores ends without an alarm [-]."""


class Sprt(Chart[SprtOptions]):
    """Log-likelihood ratio; a test that ends with "healthy" is followed by the next."""

    name = "sprt"
    summary = "Tests healthy against changed by a known amount, repeatedly; the rates apply to each test."
    source = "Wald, Annals of Mathematical Statistics 16 (1945) 117"
    equation = "L ← L + shift (x − shift/2), L ← 0 if L ≤ ln(β/(1 − α)), statistic L"
    caution = "As for cusum; α and β apply only to single tests of independent normal scores."
    Options = SprtOptions

    @property
    def n_memory(self) -> int:
        """Two: one log-likelihood ratio per direction."""
        return 2

    @property
    def limit(self) -> float:
        """Wald's limit for α and β of a single test in one direction: ln((1 − β)/α)."""
        return math.log((1.0 - self.options.missed) / self.options.false_alarms)

    @property
    def lower_limit(self) -> float:
        """Limit at which a test ends with "healthy"."""
        return math.log(self.options.missed / (1.0 - self.options.false_alarms))

    def advance(
        self, scores: Array, memory: Array, statistic: Array, limit: float, is_two_sided: bool
    ) -> None:
        """Update both log-likelihood ratios of each stream."""
        _sprt(scores, memory, statistic, limit, is_two_sided, self.options.shift, self.lower_limit)


@kernel
def _sprt(
    scores: Array,
    memory: Array,
    statistic: Array,
    limit: float,
    is_two_sided: bool,
    shift: float,
    lower_limit: float,
) -> None:
    for stream in range(scores.shape[0]):
        rising, falling = memory[stream, 0], memory[stream, 1]
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            if score != score:
                statistic[stream, instant] = score
                continue
            rising += shift * (score - 0.5 * shift)
            if rising <= lower_limit:
                rising = 0.0
            largest = rising
            if is_two_sided:
                falling -= shift * (score + 0.5 * shift)
                if falling <= lower_limit:
                    falling = 0.0
                largest = rising if rising > falling else falling
            statistic[stream, instant] = largest
            if largest >= limit:
                rising = falling = 0.0
        memory[stream, 0], memory[stream, 1] = rising, falling
