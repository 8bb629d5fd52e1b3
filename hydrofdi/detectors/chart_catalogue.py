"""Control charts: CUSUM, EWMA, generalised likelihood ratio and moving window."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.charts import Chart, ChartOptions
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
