"""On-line detector from a recursive indicator, with an optional control chart."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hydrofdi.detectors.charts import Chart, State
from hydrofdi.detectors.features import Feature
from hydrofdi.detectors.healthy_scale import HealthyScale, healthy_scale
from hydrofdi.errors import ConfigError
from hydrofdi.evaluation.direction import Direction, suspicion
from hydrofdi.indicators.recursive import RecursiveIndicator, Trace
from hydrofdi.records import Array, RecordBatch

_INDICATOR, _CHART = "indicator.", "chart."


class RecursiveDetector:
    """Computes the score of a recursive indicator in healthy spreads, chunk by chunk.

    Scores within the transient of the indicator are NaN, which raises no alarm.

    Parameters
    ----------
    indicator : RecursiveIndicator
        The score is the first of its estimates.
    chart : Chart, optional
        Control chart on the score; by default the score itself is returned. Scores that a leak lowers change
        sign first, so that ``direction: rising`` of a chart always means leakage.
    direction : Direction, optional
        Direction of an alarm; by default that of the score.
    limit : float
        The chart restarts when this limit is reached.

    Raises
    ------
    ConfigError
        No direction is given, and the score does not declare one.
    """

    def __init__(
        self,
        indicator: RecursiveIndicator[Any],
        chart: Chart[Any] | None = None,
        *,
        direction: Direction | None = None,
        limit: float = math.inf,
    ) -> None:
        self.indicator, self.chart, self.limit = indicator, chart, limit
        self.direction = Feature(indicator, indicator.estimates[0].name).direction(direction)

    def fit(self, healthy: RecordBatch) -> HealthyScale:
        """Fit median and spread to healthy scores at all instants after the transient.

        Raises
        ------
        NotStatedError
            There are too few scores, or they do not vary.
        ConfigError
            The records lack a channel.
        """
        self._require_channels(healthy)
        trace = self.indicator.trace(healthy)
        return healthy_scale(self._settled(trace, healthy.start_time))

    def score(self, model: HealthyScale, records: RecordBatch) -> Array:
        """Largest score over time of each record (n_record,); NaN if it has none."""
        scores = self.step(self.start(model, records), records)[1]
        return np.asarray(np.fmax.reduce(scores, axis=1, initial=math.nan))

    def start(self, model: HealthyScale, records: RecordBatch) -> State:
        """State before the first sample: only arrays, including the model."""
        self._require_channels(records)
        chart = {} if self.chart is None else self.chart.start(records.n_record)
        return {
            "scale": np.array([model.centre, model.spread, model.n]),
            "began": np.array([records.start_time]),
            **{_INDICATOR + name: array for name, array in self.indicator.start(records).items()},
            **{_CHART + name: array for name, array in chart.items()},
        }

    def step(self, state: State, chunk: RecordBatch) -> tuple[State, Array]:
        """State after a chunk, and the scores (n_record, n_instant) within it."""
        centre, spread, n = state["scale"]
        followed, trace = self.indicator.step(_part(state, _INDICATOR), chunk)
        settled = self._settled(trace, float(state["began"][0]))
        scores = HealthyScale(float(centre), float(spread), int(n))(settled)
        new = {**state, **{_INDICATOR + name: array for name, array in followed.items()}}
        if self.chart is None:
            return new, suspicion(scores, self.direction)
        turned = -scores if self.direction is Direction.FALLING else scores
        charted, statistic = self.chart.step(_part(state, _CHART), turned, self.limit)
        return {**new, **{_CHART + name: array for name, array in charted.items()}}, statistic

    def _require_channels(self, records: RecordBatch) -> None:
        if missing := sorted(self.indicator.channels - records.channels.keys()):
            raise ConfigError(f"{self.indicator.name} needs {' and '.join(missing)}, which the records lack")

    def _settled(self, trace: Trace, began: float) -> Array:
        """The score; NaN within the transient."""
        is_settled = trace.time - began >= self.indicator.options.transient - 1e-9
        return np.where(is_settled, trace.values[self.indicator.estimates[0].name], np.nan)


def _part(state: State, prefix: str) -> State:
    return {name.removeprefix(prefix): array for name, array in state.items() if name.startswith(prefix)}
