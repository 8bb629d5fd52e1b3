"""Evaluation of charts on the traces of a study: limits from healthy fit records, alarms of all others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hydrofdi.config.study.study import ChartConfig, OnlineConfig
from hydrofdi.detectors.charts import Chart, make_chart
from hydrofdi.detectors.healthy_scale import HealthyScale, healthy_scale
from hydrofdi.detectors.run_lengths import AlarmLimit, FalseAlarms, delays
from hydrofdi.errors import NotStatedError
from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.evaluation.scores import Array
from hydrofdi.studies.rules import Rules
from hydrofdi.studies.run_lengths.judgement import ChartJudgement, LeakDelay
from hydrofdi.studies.run_lengths.traces import Traces

_SOUND = (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)


def judge_chart(
    traces: Traces, label: str, asked: ChartConfig, online: OnlineConfig, rules: Rules
) -> Iterator[ChartJudgement]:
    """Evaluate a chart at each of its limits. Healthy fit records set the limits and are never tested.

    Parameters
    ----------
    traces : Traces
        Traces of the watched output.
    label : str
    asked : ChartConfig
    online : OnlineConfig
    rules : Rules
        Confidence level of intervals, and fraction of leaks for the late delay.
    """
    chart = make_chart(asked.chart, {"direction": traces.direction} | asked.options)
    blank = [
        ChartJudgement(label, asked.of, asked.chart, traces.unit, every) for every in online.false_alarm_every
    ]
    try:
        case = _Case.fitted(traces, chart, rules)
    except NotStatedError as refusal:
        yield from (replace(each, refusals=(str(refusal),)) for each in blank)
        return
    for each in blank:
        yield case.judged(each)


@dataclass(frozen=True, eq=False)
class _Case:
    """A chart on the standardised traces of a study."""

    traces: Traces
    scores: Array
    scale: HealthyScale
    chart: Chart[Any]
    rules: Rules

    @classmethod
    def fitted(cls, traces: Traces, chart: Chart[Any], rules: Rules) -> _Case:
        (fit,) = traces.records.chosen(Kind.HEALTHY, is_fit=True)
        scale = healthy_scale(traces.values[traces.records.rows(fit)])
        return cls(traces, scale(traces.values), scale, chart, rules)

    def judged(self, blank: ChartJudgement) -> ChartJudgement:
        """Evaluate the chart at one limit."""
        try:
            limit = self._fit.limit(blank.false_alarm_every, confidence=self.rules.confidence)
        except NotStatedError as refusal:
            return replace(blank, refusals=(str(refusal),))
        judged = replace(blank, centre=self.scale.centre, spread=self.scale.spread, limit=limit)
        sound, refusals = self._sound(limit)
        return replace(judged, false_alarms=sound, delays=tuple(self._delays(limit)), refusals=refusals)

    @cached_property
    def _fit(self) -> FalseAlarms:
        (fit,) = self.traces.records.chosen(Kind.HEALTHY, is_fit=True)
        return self._false_alarms(fit)

    def _false_alarms(self, population: Population) -> FalseAlarms:
        """False alarms of a population; its records are from different machines and therefore independent."""
        return FalseAlarms(
            self.chart, self.scores[self.traces.records.rows(population)], self.traces.interval
        )

    def _sound(self, limit: AlarmLimit) -> tuple[dict[Population, AlarmLimit], tuple[str, ...]]:
        """False alarms of all populations with healthy seals that set no limit, and refusals."""
        records, found, refusals = self.traces.records, {}, []
        for population in (each for kind in _SOUND for each in records.chosen(kind, is_fit=False)):
            try:
                at = self._false_alarms(population).at(limit.value, confidence=self.rules.confidence)
            except NotStatedError as refusal:
                refusals.append(f"no false alarms are stated for {population.title} alone: {refusal}")
            else:
                found[population] = at
        return found, tuple(refusals)

    def _delays(self, limit: AlarmLimit) -> Iterator[LeakDelay]:
        """Delays of leaks with an onset while watched; none if leaks exist from the start."""
        traces, rules = self.traces, self.rules
        for population in traces.records.chosen(Kind.FAULT, is_fit=False):
            rows = traces.records.rows(population)
            rows = rows[traces.sets_in[rows]]
            if not rows.size:
                continue
            onset = traces.onset[rows]
            found = delays(self.chart, limit.value, self.scores[rows], traces.time, onset)
            yield LeakDelay(
                population,
                float(np.mean(traces.flow[rows])),
                found.found.count,
                rows.size,
                int(found.n_early.sum()),
                found.not_measurable,
                float(traces.time[-1] - onset.max()),
                found.quantile(0.5, confidence=rules.confidence),
                found.quantile(rules.probability, confidence=rules.confidence),
            )
