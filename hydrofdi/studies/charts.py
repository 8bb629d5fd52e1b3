"""Control charts on the traces of a study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.request import RunRequest
from hydrofdi.config.study import OnlineConfig, WatchedChart
from hydrofdi.detectors.charts import Chart
from hydrofdi.detectors.rules import Rules, make_chart
from hydrofdi.detectors.run_lengths import AlarmLimit, FalseAlarms, delays
from hydrofdi.detectors.scores.contract import healthy_scale
from hydrofdi.errors import NotStatedError, ReportError
from hydrofdi.evaluation.scores import Array, Direction, Kind, Population
from hydrofdi.indicators.recursive import RecursiveIndicator
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MEAN_LEAKAGE_FLOW
from hydrofdi.studies.reading import needed_channels
from hydrofdi.studies.records import ChartJudgement, LeakDelay, StudyRecords


@dataclass(frozen=True, eq=False)
class Traces:
    """Score over time of records, without the initial transient of its estimator.

    Attributes
    ----------
    records : StudyRecords
        Records of the traces.
    values : ndarray, shape (n_record, n_instant)
        [unit]; NaN after the estimator diverged.
    time : ndarray, shape (n_instant,)
        Instants [s], on the clock of the records.
    onset : ndarray, shape (n_record,)
        Onset of the leak of a record [s]; NaN if it exists from the start.
    flow : ndarray, shape (n_record,)
        True mean leakage flow from the onset on [m³/s]; NaN if the run failed.
    unit : str
        SI.
    direction : Direction
        Direction of change of the score that means a leak.
    """

    records: StudyRecords
    values: Array
    time: Array
    onset: Array
    flow: Array
    unit: str = "1"
    direction: Direction = Direction.BOTH

    @property
    def interval(self) -> float:
        """Time between instants [s]."""
        return float(self.time[1] - self.time[0])

    @property
    def sets_in(self) -> NDArray[np.bool_]:
        """Whether the onset of the leak is within the watched time, shape (n_record,)."""
        is_watched = (self.onset > self.time[0]) & (self.onset < self.time[-1])
        return np.asarray(is_watched & np.isfinite(self.flow))


def read_traces(data: ExperimentData, records: StudyRecords, watched: str) -> Traces:
    """Read the traces of a score in a design of a stored study."""
    label = watched.partition(".")[0]
    indicator = data.indicators[label]
    stored = data.columns.get(f"{watched}_trace")
    if stored is None or not isinstance(indicator, RecursiveIndicator):
        raise ReportError(f"{data.path}: contains no trace of {watched}; sweep again")
    request = data.experiment.nominal_parameters.with_values(records.design)
    time = watched_instants(indicator, request)
    if time.size < 2:
        raise ReportError(f"the trace of {watched} ends before its transient is over")
    is_constant = np.array([kind == "constant" for kind in data.values("leakage.onset")])
    onsets = np.where(is_constant, np.nan, np.array(data.values("leakage.onset_time"), dtype=float))
    rows, onset = records.runs, onsets[records.runs]
    with np.errstate(divide="ignore", invalid="ignore"):
        # The stored mean flow is over the whole record, also before the onset.
        share = 1.0 - np.where(np.isnan(onset), 0.0, onset) / request.record.duration
        flow = data.columns[MEAN_LEAKAGE_FLOW][rows] / share
    score = indicator.estimates[0]
    return Traces(
        records,
        np.asarray(stored[rows], dtype=float)[:, indicator.n_instant - time.size : indicator.n_instant],
        time,
        onset,
        flow,
        score.unit,
        Direction.BOTH if score.direction is None else score.direction,
    )


def watched_instants(indicator: RecursiveIndicator[Any], request: RunRequest) -> Array:
    """Instants of a stored trace after its transient [s], on the clock of the whole record."""
    frequency = request.record.sampling_frequency
    instants = indicator.trace_instants(frequency)
    # An instant at the end of the transient counts, whatever its last bit.
    settled = instants[instants >= indicator.options.transient - 1e-9]
    return np.asarray(settled + request.n_discarded / frequency)


_SOUND = (Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION)


def judge_chart(
    traces: Traces, label: str, asked: WatchedChart, online: OnlineConfig, rules: Rules
) -> Iterator[ChartJudgement]:
    """Evaluate a chart at each of its limits. Healthy fit records set the limits and are never tested."""
    records, confidence = traces.records, rules.confidence
    chart = make_chart(asked.chart, {"direction": traces.direction} | asked.options)
    (fit,) = records.chosen(Kind.HEALTHY, is_fit=True)
    every = online.false_alarm_every
    blank = [ChartJudgement(label, asked.of, asked.chart, traces.unit, each) for each in every]
    try:
        centre, spread = healthy_scale(traces.values[records.rows(fit)])
    except NotStatedError as refusal:
        yield from (replace(each, refusals=(str(refusal),)) for each in blank)
        return
    scores = (traces.values - centre) / spread
    fitted = FalseAlarms(chart, scores[records.rows(fit)], traces.interval)
    for each in blank:
        try:
            limit = fitted.limit(each.false_alarm_every, confidence=confidence)
        except NotStatedError as refusal:
            yield replace(each, refusals=(str(refusal),))
            continue
        found, refusals = dict[Population, AlarmLimit](), []
        for population in (tested for kind in _SOUND for tested in records.chosen(kind, is_fit=False)):
            try:
                of = FalseAlarms(chart, scores[records.rows(population)], traces.interval)
                found[population] = of.at(limit.value, confidence=confidence)
            except NotStatedError as refusal:
                refusals.append(f"no false alarms are stated for {population.title} alone: {refusal}")
        yield replace(
            each,
            centre=centre,
            spread=spread,
            limit=limit,
            false_alarms=found,
            delays=tuple(_delays(traces, scores, chart, limit, rules)),
            refusals=tuple(refusals),
        )


def _delays(
    traces: Traces, scores: Array, chart: Chart[Any], limit: AlarmLimit, rules: Rules
) -> Iterator[LeakDelay]:
    """Delays of leaks with an onset while watched; none if leaks exist from the start."""
    for population in traces.records.chosen(Kind.FAULT, is_fit=False):
        rows = traces.records.rows(population)
        rows = rows[traces.sets_in[rows]]
        if not rows.size:
            continue
        onset = traces.onset[rows]
        found = delays(chart, limit.value, scores[rows], traces.time, onset)
        yield LeakDelay(
            population,
            float(np.mean(traces.flow[rows])),
            int(np.isfinite(found.values).sum()),
            rows.size,
            int(found.n_early.sum()),
            found.not_measurable,
            float(traces.time[-1] - onset.max()),
            found.quantile(0.5, confidence=rules.confidence),
            found.quantile(rules.probability, confidence=rules.confidence),
        )


def judge_charts(data: ExperimentData, records: StudyRecords) -> Iterator[ChartJudgement]:
    """Evaluate the charts of a design of a stored study.

    Charts on indicators that need sensors which the machine does not have are omitted.
    """
    detection = data.experiment.detection
    if (online := detection.online) is None:
        return
    for label, asked in online.charts.items():
        indicator = data.indicators[asked.of.partition(".")[0]]
        if not detection.sensors or set(needed_channels(indicator)) <= set(detection.sensors):
            yield from judge_chart(read_traces(data, records, asked.of), label, asked, online, detection)
