"""Control charts on the time series of a score: CUSUM, EWMA and generalised likelihood ratio.

The input of a chart are standardised scores (median 0 and spread 1 if healthy); it does not depend on their
interval or on the indicator. It raises an alarm when its statistic reaches the limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.rules import Method
from hydrofdi.evaluation.scores import Array, Direction
from hydrofdi.settings.quantities import SI, Section

State = Mapping[str, NDArray[Any]]
"""State of a chart between chunks: arrays, so that it can be stored."""

LARGEST = 1e9
"""Standardised scores are limited to ± this value; infinite scores too."""


class ChartOptions(Section):
    """Options of every chart."""

    direction: Direction = Direction.BOTH
    """Direction in which the score raises an alarm: ``rising``, ``falling`` or ``both``."""


Chosen = TypeVar("Chosen", bound=ChartOptions)


class Chart(Method[Chosen]):
    """Interface of a chart: a statistic of all scores so far; x in its equation is the standardised score.

    Attributes
    ----------
    kernel : callable
        Takes scores and statistic, shape (n_stream, n_time), memory, shape (n_stream, n_memory), the limit,
        whether it is two-sided, and `arguments`. It fills the statistic and updates the memory. A NaN score
        leaves the memory unchanged and gives NaN; the memory is reset to zero when the limit is reached.
    """

    kernel: ClassVar[Callable[..., None]]

    @property
    def n_memory(self) -> int:
        """Number of memory values per stream; all are zero at the start."""
        return 2

    @property
    def arguments(self) -> tuple[Any, ...]:
        """Further arguments of the kernel."""
        return ()

    def start(self, n_stream: int) -> State:
        """State before the first score."""
        return {"memory": np.zeros((n_stream, self.n_memory))}

    def step(self, state: State, scores: ArrayLike, limit: float = math.inf) -> tuple[State, Array]:
        """State after a chunk, and its statistic; the old state is not modified.

        The statistic of a stream is bit-identical however it is split into chunks. NaN scores are skipped:
        their statistic is NaN, which raises no alarm.

        Parameters
        ----------
        scores : array_like, shape (n_stream, n_time)
            Standardised [-].
        limit : float
            The chart restarts when the statistic reaches it.

        Returns
        -------
        statistic : ndarray, shape (n_stream, n_time)
            Alarm if statistic >= limit.
        """
        direction = self.options.direction
        sign = -1.0 if direction is Direction.FALLING else 1.0
        held = np.ascontiguousarray(np.clip(sign * np.asarray(scores, dtype=float), -LARGEST, LARGEST))
        # A copy, as the caller keeps the old state.
        memory = np.array(state["memory"], dtype=float, order="C")
        if held.ndim != 2 or held.shape[0] != memory.shape[0]:
            raise ValueError(f"expected scores of {memory.shape[0]} streams in the shape (n_stream, n_time)")
        statistic = np.empty_like(held)
        self.kernel(held, statistic, memory, float(limit), direction is Direction.BOTH, *self.arguments)
        return {"memory": memory}, statistic

    def follow(self, scores: ArrayLike, limit: float = math.inf) -> Array:
        """Statistic of whole streams, shape (n_stream, n_time)."""
        values = np.asarray(scores, dtype=float)
        return self.step(self.start(values.shape[0]), values, limit)[1]


@kernel
def _cusum(
    scores: Array, statistic: Array, memory: Array, limit: float, is_two_sided: bool, reference: float
) -> None:
    for stream in range(scores.shape[0]):
        rising, falling = memory[stream, 0], memory[stream, 1]
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            # Only NaN differs from itself.
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


class CusumOptions(ChartOptions):
    """Options of `Cusum`."""

    shift: Annotated[float, SI("1", above=0)] = 1.0
    """Change of the mean that is detected fastest, in healthy standard deviations [-]; k is half of it."""


class Cusum(Chart[CusumOptions]):
    """Page's cumulative sum with reference value k, two-sided unless a direction is chosen.

    C⁺ ← max(0, C⁺ + x − k), C⁻ ← max(0, C⁻ − x − k), statistic max(C⁺, C⁻), k = shift/2.

    Page, Biometrika 41 (1954) 100; Lorden, Annals of Mathematical Statistics 42 (1971) 1897.
    """

    name = "cusum"
    summary = (
        "Accumulates the excess of the scores over half the expected change; optimal for a change of that"
        " size."
    )
    caution = "Healthy records with a mean above k accumulate like a leak: use a larger shift."
    Options = CusumOptions
    kernel = staticmethod(_cusum)

    @property
    def arguments(self) -> tuple[float]:
        """The reference value k."""
        return (self.options.shift / 2.0,)


@kernel
def _ewma(
    scores: Array,
    statistic: Array,
    memory: Array,
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
            # 1 − (1 − λ)^(2t) step by step, so that a stream may be split anywhere.
            settled = kept * settled + (1.0 - kept)
            variance = limiting * settled if is_exact else limiting
            size = mean / variance**0.5
            if is_two_sided and size < 0.0:
                size = -size
            statistic[stream, instant] = size
            if size >= limit:
                mean = settled = 0.0
        memory[stream, 0], memory[stream, 1] = mean, settled


class EwmaOptions(ChartOptions):
    """Options of `Ewma`."""

    weight: Annotated[float, SI("1", above=0, most=1)] = 0.1
    """Weight λ of the newest score [-]; the memory is about 1/λ scores. 1: each score by itself."""

    variance: Literal["exact", "limiting"] = "exact"
    """Variance of the average: ``exact`` for the time since the start, or its limit (``limiting``)."""


class Ewma(Chart[EwmaOptions]):
    """Exponentially weighted mean over its standard deviation for independent scores.

    z ← (1 − λ) z + λ x, statistic |z|/σ, σ² = λ/(2 − λ) (1 − (1 − λ)²ᵗ).

    Roberts, Technometrics 1 (1959) 239; Lucas and Saccucci, Technometrics 32 (1990) 1.
    """

    name = "ewma"
    summary = (
        "Exponentially weighted mean over its standard deviation; for changes of up to about one spread."
    )
    caution = "With dependent scores the spread of the mean exceeds σ: set the limit from records."
    Options = EwmaOptions
    kernel = staticmethod(_ewma)

    @property
    def arguments(self) -> tuple[float, bool]:
        """Weight, and whether the variance is exact."""
        return self.options.weight, self.options.variance == "exact"


@kernel
def _glr(scores: Array, statistic: Array, memory: Array, limit: float, is_two_sided: bool) -> None:
    for stream in range(scores.shape[0]):
        for instant in range(scores.shape[1]):
            score = scores[stream, instant]
            if score != score:
                statistic[stream, instant] = score
                continue
            total, largest = 0.0, 0.0
            for length in range(1, memory.shape[1] + 1):
                # The memory, newest score first, shifts by one while the sum grows over it.
                earlier = memory[stream, length - 1]
                memory[stream, length - 1] = score
                total += score
                size = abs(total)
                # The sum times its size keeps the sign, so that falls do not count if only rises do.
                ratio = size * (size if is_two_sided else total) / (2.0 * length)
                largest = ratio if ratio > largest else largest
                score = earlier
            statistic[stream, instant] = largest
            if largest >= limit:
                for index in range(memory.shape[1]):
                    memory[stream, index] = 0.0


class GlrOptions(ChartOptions):
    """Options of `Glr`."""

    window: Annotated[int, Field(ge=1)] = 100
    """Number of newest scores searched for a change."""


class Glr(Chart[GlrOptions]):
    """Log-likelihood ratio of the best change of the mean within the window against no change.

    statistic max over j ≤ window of S²/(2 j), S the sum of the j newest scores.

    Willsky and Jones, IEEE Trans. Automatic Control 21 (1976) 108; Lai, Journal of the Royal Statistical
    Society B 57 (1995) 613.
    """

    name = "glr"
    summary = "Most likely change of the mean, of any size and at any instant within a window."
    caution = "Changes before the window are not detected; the cost grows with the window."
    Options = GlrOptions
    kernel = staticmethod(_glr)

    @property
    def n_memory(self) -> int:
        """The newest scores, padded with zeros, which do not change the largest ratio."""
        return self.options.window
