"""Control charts on a score over time, CUSUM, EWMA, generalised likelihood ratio, and their run lengths.

The input of a chart are standardised scores (median 0 and spread 1 if healthy); it does not depend on their
interval or on the indicator. It raises an alarm when its statistic reaches the limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from hydrofdi.compilation.object_code import kernel
from hydrofdi.detectors.rules import Method
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.rates import FEWEST_GROUPS
from hydrofdi.evaluation.scores import Array, Direction, Estimate, comparable, group_numbers
from hydrofdi.settings.quantities import SI

State = Mapping[str, NDArray[Any]]
"""State of a chart between chunks: arrays, so that it can be stored."""

LARGEST = 1e9
"""Standardised scores are limited to ± this value; infinite scores too."""


class Chart(Method):
    """Interface of a chart: a statistic of all scores so far; x in its equation is the standardised score.

    Attributes
    ----------
    kernel : callable
        Takes scores and statistic, shape (n_stream, n_time), memory, shape (n_stream, n_memory), the limit,
        whether it is two-sided, and `arguments`. It fills the statistic and updates the memory. A NaN score
        leaves the memory unchanged and gives NaN; the memory is reset to zero when the limit is reached.
    """

    kernel: ClassVar[Callable[..., None]]

    direction: Direction = Direction.BOTH
    """Direction in which the score raises an alarm: ``rising``, ``falling`` or ``both``."""

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
        sign = -1.0 if self.direction is Direction.FALLING else 1.0
        held = np.ascontiguousarray(np.clip(sign * np.asarray(scores, dtype=float), -LARGEST, LARGEST))
        # A copy, as the caller keeps the old state.
        memory = np.array(state["memory"], dtype=float, order="C")
        if held.ndim != 2 or held.shape[0] != memory.shape[0]:
            raise ValueError(f"expected scores of {memory.shape[0]} streams in the shape (n_stream, n_time)")
        statistic = np.empty_like(held)
        self.kernel(held, statistic, memory, float(limit), self.direction is Direction.BOTH, *self.arguments)
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


class Cusum(Chart):
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
    kernel = staticmethod(_cusum)

    shift: Annotated[float, SI("1", above=0)] = 1.0
    """Change of the mean that is detected fastest, in healthy standard deviations [-]; k is half of it."""

    @property
    def arguments(self) -> tuple[float]:
        """The reference value k."""
        return (self.shift / 2.0,)


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


class Ewma(Chart):
    """Exponentially weighted mean over its standard deviation for independent scores.

    z ← (1 − λ) z + λ x, statistic |z|/σ, σ² = λ/(2 − λ) (1 − (1 − λ)²ᵗ).

    Roberts, Technometrics 1 (1959) 239; Lucas and Saccucci, Technometrics 32 (1990) 1.
    """

    name = "ewma"
    summary = (
        "Exponentially weighted mean over its standard deviation; for changes of up to about one spread."
    )
    caution = "With dependent scores the spread of the mean exceeds σ: set the limit from records."
    kernel = staticmethod(_ewma)

    weight: Annotated[float, SI("1", above=0, most=1)] = 0.1
    """Weight λ of the newest score [-]; the memory is about 1/λ scores. 1: each score by itself."""

    variance: Literal["exact", "limiting"] = "exact"
    """Variance of the average: ``exact`` for the time since the start, or its limit (``limiting``)."""

    @property
    def arguments(self) -> tuple[float, bool]:
        """Weight, and whether the variance is exact."""
        return self.weight, self.variance == "exact"


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


class Glr(Chart):
    """Log-likelihood ratio of the best change of the mean within the window against no change.

    statistic max over j ≤ window of S²/(2 j), S the sum of the j newest scores.

    Willsky and Jones, IEEE Trans. Automatic Control 21 (1976) 108; Lai, Journal of the Royal Statistical
    Society B 57 (1995) 613.
    """

    name = "glr"
    summary = "Most likely change of the mean, of any size and at any instant within a window."
    caution = "Changes before the window are not detected; the cost grows with the window."
    kernel = staticmethod(_glr)

    window: Annotated[int, Field(ge=1)] = 100
    """Number of newest scores searched for a change."""

    @property
    def n_memory(self) -> int:
        """The newest scores, padded with zeros, which do not change the largest ratio."""
        return self.window


HOUR = 3600.0

PRECISION = 1e-4
"""Relative width at which the bisection for a limit ends."""

LEAST = 1e-3
"""Smallest limit [of standardised scores]; the statistic of many charts is zero most of the time."""

CHUNK = 2**16
"""Number of scores that a chart processes at a time, so that they fit the processor cache."""


@dataclass(frozen=True)
class AlarmLimit:
    """A limit of a chart, and its rate of false alarms.

    Attributes
    ----------
    mean_time : float
        Mean time between false alarms [s]; infinite if there was no alarm.
    low, high : float
        Confidence interval of the mean time [s].
    n_alarm : float
        Mean number of false alarms per resampled healthy operation of the length of the data.
    """

    value: float
    mean_time: float
    low: float
    high: float
    confidence: float
    n_alarm: float
    duration: float


class FalseAlarms:
    """False alarms of a chart in healthy operation.

    Whole healthy records are drawn with replacement and concatenated; the chart continues across the joints
    and restarts after each alarm. So dependence within records is preserved, and records are independent of
    each other.

    Parameters
    ----------
    streams : array_like, shape (n_stream, n_time)
        Standardised scores of healthy records [-]. Cut a long record into nearly independent pieces, and omit
        its transient; NaN scores are skipped.
    interval : float
        Time between scores [s].
    groups : sequence of str, length n_stream, optional
        Group of each stream; streams of a group are drawn together.
    n_draw : int
        Number of resamples for an interval; the search for a limit uses a tenth.
    """

    def __init__(
        self,
        chart: Chart,
        streams: ArrayLike,
        interval: float,
        *,
        groups: Sequence[str] | None = None,
        n_draw: int = 100,
    ) -> None:
        self.chart = chart
        self.streams: Array = np.ascontiguousarray(streams, dtype=float)
        group_of = group_numbers(groups or ("",) * self.streams.shape[0])
        self.groups = [np.flatnonzero(group_of == group) for group in np.unique(group_of)]
        self.n_draw, self._n_search = n_draw, max(1, n_draw // 10)
        self.duration = int(np.sum(~np.isnan(self.streams))) * interval
        if len(self.groups) < FEWEST_GROUPS:
            raise NotStatedError(
                f"a time between false alarms needs {FEWEST_GROUPS} independent healthy records,"
                f" not {len(self.groups)}",
                FEWEST_GROUPS,
            )
        if not self.duration:
            raise NotStatedError("no healthy record has a time series of scores")
        self._searched: dict[float, float] = {}

    def at(self, limit: float, *, confidence: float = 0.95) -> AlarmLimit:
        """Mean time between false alarms at a limit.

        The interval is that of a Poisson count (Garwood, Biometrika 28 (1936) 437) with an effective number
        of alarms from the variance over the resamples, at most the actual number. A percentile bootstrap is
        not suitable: with few alarms it cannot extrapolate beyond the largest score.
        """
        from scipy.special import gammaincinv

        n_group = len(self.groups)
        counts = np.array(self._counts(limit, self.n_draw))
        mean = float(counts.mean())
        # At least that of a Poisson count, so that the effective number is at most the actual one.
        variance = max(float(counts.var(ddof=1)) * n_group / (n_group - 1), mean)
        scale = variance / mean if mean else 1.0
        effective, each = mean / scale, (1.0 - confidence) / 2.0
        least = float(gammaincinv(effective, each)) * scale if mean else 0.0
        most = float(gammaincinv(effective + 1.0, 1.0 - each)) * scale
        low, value, high = (self.duration / n if n else math.inf for n in (most, mean, least))
        return AlarmLimit(limit, value, low, high, confidence, mean, self.duration)

    def limit(self, mean_time: float, *, confidence: float = 0.95) -> AlarmLimit:
        """Limit for a required mean time between false alarms.

        It is the largest limit that ⌊duration/mean_time⌋ alarms reach, as in `quantile_threshold` for
        records. On average over healthy data, the mean time is then at least the required one.
        """
        wanted = math.floor(self.duration / mean_time + 1e-9)
        if not wanted:
            hours, have = f"{mean_time / HOUR:.3g} h", self.duration / HOUR
            raise NotStatedError(
                f"a mean time of {hours} between false alarms needs {hours} of healthy scores, not"
                f" {have:.3g} h",
                math.ceil(mean_time / self.duration * self.streams.shape[0] - 1e-9),
            )
        return self.at(self._search(wanted), confidence=confidence)

    def _search(self, wanted: float) -> float:
        low, high = LEAST, self._highest
        while self._mean_count(high) >= wanted:
            low, high = high, 2.0 * high
        if self._mean_count(low) < wanted:
            raise NotStatedError(
                "no limit above 0 has so many false alarms; choose a longer time between false alarms"
            )
        # Limits that were tried before narrow the bracket.
        low = max(limit for limit, count in self._searched.items() if count >= wanted and limit < high)
        high = min(limit for limit, count in self._searched.items() if count < wanted and limit > low)
        while high - low > PRECISION * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._mean_count(middle) >= wanted else (low, middle)
        return low

    @cached_property
    def _highest(self) -> float:
        """Upper bound of the statistic over all resamples of the search."""
        # Just above, as a statistic at the limit is an alarm.
        return (1.0 + 1e-9) * max(
            float(np.nanmax(each, initial=LEAST))
            for draw in self._followed(self._n_search, math.inf)
            for each in draw
        )

    def _mean_count(self, limit: float) -> float:
        if limit not in self._searched:
            self._searched[limit] = float(np.mean(self._counts(limit, self._n_search)))
        return self._searched[limit]

    def _counts(self, limit: float, n_draw: int) -> list[int]:
        """Number of false alarms in each resample."""
        return [
            sum(int(np.count_nonzero(each >= limit)) for each in draw)
            for draw in self._followed(n_draw, limit)
        ]

    def _followed(self, n_draw: int, limit: float) -> Iterator[Iterator[Array]]:
        """Statistic of each resample, in chunks."""

        def along(drawn: NDArray[np.intp]) -> Iterator[Array]:
            state, n_joined = self.chart.start(1), max(1, CHUNK // self.streams.shape[1])
            for first in range(0, drawn.size, n_joined):
                joined = self.streams[drawn[first : first + n_joined]].reshape(1, -1)
                state, statistic = self.chart.step(state, joined, limit)
                yield statistic

        return map(along, operations(self.groups, n_draw))


def operations(groups: list[NDArray[np.intp]], n_draw: int) -> Iterator[NDArray[np.intp]]:
    """Draw whole streams to be concatenated: block bootstrap with the streams of a group as blocks.

    Künsch, Annals of Statistics 17 (1989) 1217, with blocks given by records; balanced as in Davison, Hinkley
    and Schechtman, Biometrika 73 (1986) 555: over all draws each group occurs equally often.

    Yields
    ------
    ndarray of int, shape (n_drawn,)
        Positions of streams; their number equals that of all streams if groups have equal size.
    """
    order = np.random.default_rng(0).permutation(np.tile(np.arange(len(groups)), n_draw))
    for drawn in order.reshape(n_draw, len(groups)):
        yield np.concatenate([groups[group] for group in drawn])


@dataclass(frozen=True, eq=False)
class Delays:
    """Detection delay of the leak in each stream.

    Attributes
    ----------
    values : ndarray, shape (n_stream,)
        Time from the onset to the first alarm at or after it [s]; infinite if there is none.
    n_early : ndarray of int, shape (n_stream,)
        Number of alarms before the onset: false alarms, not detections. The chart restarts after each.
    not_measurable : int
        Number of streams without a score after the onset; they count as not detected.
    watched : float
        Time from the latest onset to the last instant [s].
    """

    values: Array
    n_early: np.ndarray
    not_measurable: int
    watched: float = math.inf

    def quantile(self, share: float = 0.5, *, confidence: float = 0.95) -> Estimate:
        """Delay within which a given share of the leaks is detected; infinite if too many are not.

        Its distribution-free interval is that of order statistics: David and Nagaraja, Order Statistics
        (2003), section 7.1.
        """
        ordered = np.sort(self.values)
        rank = max(math.ceil(share * ordered.size - 1e-9), 1)
        value = float(ordered[rank - 1]) if ordered.size else math.nan
        return Estimate(value, *_order_statistics(ordered, share, confidence))


def delays(chart: Chart, limit: float, streams: ArrayLike, instants: ArrayLike, onset: ArrayLike) -> Delays:
    """Detection delays of a chart that runs from the start of each stream.

    Parameters
    ----------
    streams : array_like, shape (n_stream, n_time)
        Standardised scores [-].
    instants : array_like, shape (n_time,)
        Instants of the scores [s].
    onset : array_like, scalar or shape (n_stream,)
        Onset of the leak [s].
    """
    scores, times = np.asarray(streams, dtype=float), np.asarray(instants, dtype=float)
    sets_in = np.broadcast_to(np.asarray(onset, dtype=float), scores.shape[:1])[:, None]
    is_alarm, is_later = chart.follow(scores, limit) >= limit, comparable(times) >= comparable(sets_in)
    first = np.where(is_alarm & is_later, times, math.inf).min(axis=1, initial=math.inf)
    unscored = int((~(is_later & ~np.isnan(scores)).any(axis=1)).sum())
    early = np.sum(is_alarm & ~is_later, axis=1)
    # An instant that rounds to the onset may lie just before it.
    late = float(times[-1] - sets_in.max(initial=-math.inf))
    return Delays(np.maximum(first - sets_in[:, 0], 0.0), early, unscored, late)


def _order_statistics(ordered: Array, share: float, confidence: float) -> tuple[float, float]:
    from scipy.special import bdtr

    ranks, each = np.arange(ordered.size + 1), (1.0 - confidence) / 2.0
    below = comparable(bdtr(ranks, ordered.size, share))
    lower = int(np.sum(below <= comparable(each)))
    upper = int(np.sum(below < comparable(1.0 - each))) + 1
    low = float(ordered[lower - 1]) if lower else 0.0
    return low, float(ordered[upper - 1]) if upper <= ordered.size else math.inf
