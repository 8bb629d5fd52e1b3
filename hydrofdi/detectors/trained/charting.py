"""Control chart of a trained detector, over windows or estimates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hydrofdi.detectors.charts import State, make_chart
from hydrofdi.detectors.trained.file import DetectorFile, Scale
from hydrofdi.detectors.trained.measuring import feature_of
from hydrofdi.detectors.trained.verdict import Verdict
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction
from hydrofdi.records import Array


@dataclass(frozen=True)
class ChartReading:
    """Reading of the control chart: statistic and limit [healthy spreads], and whether it alarms."""

    statistic: float | None
    limit: float
    alarm: bool


def standardised(scores: ArrayLike, healthy: Scale, direction: Direction) -> Array:
    """Scores in healthy spreads from the healthy median; the sign changes if a leak lowers the score."""
    values = (np.asarray(scores, dtype=float) - healthy.centre) / healthy.spread
    return np.asarray(-values if direction is Direction.FALLING else values)


class ScoreChart:
    """Chart of a trained detector. Windows that are not judged do not change it.

    Parameters
    ----------
    file : DetectorFile

    Raises
    ------
    ConfigError
        The detector has no chart.
    """

    def __init__(self, file: DetectorFile) -> None:
        if file.chart is None or file.config.chart is None:
            raise ConfigError("the detector has no chart")
        self._chart = make_chart(file.config.chart.chart, file.config.chart.options)
        self._limit, self._healthy = file.chart.limit, file.healthy
        self._direction = feature_of(file.config).direction(file.config.direction)

    def start(self) -> State:
        """State before the first window: only arrays."""
        return self._chart.start(1)

    def step(self, state: State, verdict: Verdict) -> tuple[State, ChartReading]:
        """State and reading after a window."""
        judged = math.nan if verdict.alarm is None or verdict.score is None else verdict.score
        score = standardised(judged, self._healthy, self._direction)
        after, statistic = self._chart.step(state, score.reshape(1, 1), self._limit)
        reached = float(statistic[0, 0])
        if math.isnan(reached):
            return after, ChartReading(None, self._limit, False)
        return after, ChartReading(reached, self._limit, reached >= self._limit)


def chart_of(file: DetectorFile) -> ScoreChart | None:
    """Chart of a trained detector; None if it has no chart."""
    return None if file.chart is None else ScoreChart(file)
