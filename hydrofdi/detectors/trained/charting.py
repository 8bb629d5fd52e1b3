"""Control chart of a trained detector over windows or estimates, and its limit from healthy scores."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.detectors.charts.contract import State
from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.run_lengths import FalseAlarms
from hydrofdi.detectors.trained.configuration import ChartConfig, direction_of
from hydrofdi.detectors.trained.file import ChartLimit, DetectorFile, Scale
from hydrofdi.detectors.trained.judging import Verdict
from hydrofdi.detectors.trained.scoring import HealthyScores
from hydrofdi.evaluation.direction import Direction
from hydrofdi.evaluation.grouped_area import FEWEST_GROUPS
from hydrofdi.records import Array

_N_PIECE = 20
"""Number of pieces that records are cut into if there are fewer than five records."""

_HOUR = 3600.0

RestsOn = Literal["pieces", "records", "groups"]


@dataclass(frozen=True)
class ChartReading:
    """Reading of the control chart: statistic and limit [healthy spreads], and whether it alarms."""

    statistic: float | None
    limit: float
    alarm: bool


class ScoreChart:
    """Chart of a trained detector that has one. Windows that are not judged do not change it.

    Parameters
    ----------
    file : DetectorFile
    """

    def __init__(self, file: DetectorFile) -> None:
        assert file.chart is not None
        assert file.config.chart is not None
        self._chart = make_chart(file.config.chart.chart, file.config.chart.options)
        self._limit, self._healthy = file.chart.limit, file.healthy
        self._direction = direction_of(file.config)

    def start(self) -> State:
        """State before the first window: only arrays."""
        return self._chart.start(1)

    def step(self, state: State, verdict: Verdict) -> tuple[State, ChartReading]:
        """State and reading after a window."""
        judged = math.nan if verdict.alarm is None or verdict.score is None else verdict.score
        score = _standardised(judged, self._healthy, self._direction)
        after, statistic = self._chart.step(state, score.reshape(1, 1), self._limit)
        reached = float(statistic[0, 0])
        if math.isnan(reached):
            return after, ChartReading(None, self._limit, False)
        return after, ChartReading(reached, self._limit, reached >= self._limit)


def chart_in_full(chart: ChartConfig, direction: Direction) -> ChartConfig:
    """Chart configuration with all options; the direction refers to scores that rise with leakage."""
    turned = Direction.BOTH if direction is Direction.BOTH else Direction.RISING
    made = make_chart(chart.chart, {"direction": turned, **chart.options})
    return chart.model_copy(update={"options": made.options.model_dump(mode="json")})


def chart_limit(
    found: HealthyScores, chart: ChartConfig, healthy: Scale, direction: Direction, confidence: float
) -> ChartLimit:
    """Limit that healthy scores, in time order, reach once within the required time on average.

    Parameters
    ----------
    found : HealthyScores
    chart : ChartConfig
        Chart configuration with all options.
    healthy : Scale
    direction : Direction
        Direction of the score.
    confidence : float

    Raises
    ------
    NotStatedError
        The healthy records are shorter in total than the required time; the message states the required
        length.
    """
    lines = [_standardised(each.scores, healthy, direction) for each in found.lines]
    groups: list[str] | None = None
    rests_on: RestsOn = "pieces"
    if len(set(found.groups)) >= FEWEST_GROUPS:
        groups, rests_on = found.groups, "groups" if found.has_groups else "records"
    else:
        length = max(1, sum(line.size for line in lines) // _N_PIECE)
        lines = [line[first : first + length] for line in lines for first in range(0, line.size, length)]
    made = make_chart(chart.chart, chart.options)
    alarms = FalseAlarms(made, _side_by_side(lines), found.interval, groups=groups).limit(
        chart.false_alarm_every, confidence=confidence
    )
    return ChartLimit(
        limit=alarms.value,
        mean_time=finite(alarms.mean_time),
        interval=(alarms.low, finite(alarms.high)),
        hours=alarms.duration / _HOUR,
        rests_on=rests_on,
    )


def _standardised(scores: ArrayLike, healthy: Scale, direction: Direction) -> Array:
    """Scores in healthy spreads from the healthy median; the sign changes if a leak lowers the score."""
    values = (np.asarray(scores, dtype=float) - healthy.centre) / healthy.spread
    return np.asarray(-values if direction is Direction.FALLING else values)


def _side_by_side(lines: Sequence[Array]) -> Array:
    """Scores as an array, padded with NaN."""
    streams = np.full((len(lines), max(line.size for line in lines)), np.nan)
    for row, line in enumerate(lines):
        streams[row, : line.size] = line
    return streams


def finite(value: float) -> float | None:
    """The value; None if it is infinite."""
    return value if math.isfinite(value) else None
