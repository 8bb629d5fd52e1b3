"""What a study shows: its scores, ranked, and the detector of the best; its charts; its estimates."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.machine import flow_at_reference
from hydrofdi.config.study import OnlineConfig, WatchedChart
from hydrofdi.detectors.charts import AlarmLimit, Chart, Delays, FalseAlarms, delays
from hydrofdi.detectors.configuration import stated_indicators
from hydrofdi.detectors.rules import CHANGE, Rules, make_chart
from hydrofdi.detectors.scores.contract import healthy_scale
from hydrofdi.errors import ConfigError, NotStatedError, ReportError
from hydrofdi.evaluation.rates import alarm_rate, confidence_text, simultaneous_confidence
from hydrofdi.evaluation.scores import Array, Direction, Kind
from hydrofdi.indicators.contract import RecursiveIndicator
from hydrofdi.records import Channel
from hydrofdi.settings.messages import convert, counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import BULK_MODULUS, LEAKAGE_COEFFICIENT, MEAN_LEAKAGE_FLOW, MISSING, STATUS
from hydrofdi.studies.judging import judge
from hydrofdi.studies.reading import needed_channels, read_study, within
from hydrofdi.studies.records import (
    SOUND,
    ChartJudgement,
    Detection,
    Judgement,
    Notes,
    Outcome,
    Scored,
    StudyRecords,
    pareto_set,
    ranked,
)


def detect(records: StudyRecords, scores: Sequence[Scored], rules: Rules) -> Detection:
    """Evaluate all scores of a study.

    Top-ranked scores and scores in the Pareto set were selected among many, so they get a second bound,
    ``q90_95_of_all``, that is simultaneous for all scores.
    """
    judged = [judge(records, scored, rules) for scored in scores]
    judgements = ranked(judged, is_labelled=records.is_labelled)
    best = pareto_set(judgements)
    judgements = tuple(
        judge(records, each.scored, rules, n_tried=len(scores)) if rank == 0 or each.name in best else each
        for rank, each in enumerate(judgements)
    )
    return Detection(
        records, judgements, rules, best, (*records.remarks, *_remarks(records, len(scores), rules))
    )


def _remarks(records: StudyRecords, n_tried: int, rules: Rules) -> list[str]:
    remarks = []
    if n_tried > 1:
        together = simultaneous_confidence(rules.confidence, n_tried)
        remarks.append(
            f"{counted(n_tried, 'score')} were tried. The bounds apply to a"
            " score chosen in advance. If you pick the"
            f" best of {n_tried}, use the {confidence_text(together)} % bound (Bonferroni)"
        )
    if records.groups is not None:
        n_group = len(set(records.groups))
        remarks.append(
            f"{counted(n_group, 'group')}: intervals of rates allow for"
            " differences between groups, curves of detection"
            " do not"
        )
    if not records.chosen(Kind.FAULT, is_fit=False):
        remarks.append("no faulty record is tested: there are no results on detection")
    return remarks


def judge_study(data: ExperimentData) -> tuple[Detection, ...]:
    """Evaluate every score of every design of a stored study."""
    rules = data.experiment.detection
    return tuple(detect(records, scores, rules) for records, scores in read_study(data))


def winner(detection: Detection, sensors: Collection[str] = ()) -> Judgement | None:
    """The best score that keeps its false-alarm rate, can be trained and needs no more than some sensors.

    Changes since an earlier record cannot be trained: a detector judges each record by itself.
    """
    for judgement in detection.judgements:
        is_change = any(name.endswith(CHANGE) for name in judgement.scored.numbers)
        if judgement.keeps_its_rate and within(judgement.scored, sensors) and not is_change:
            return judgement
    return None


def detector_settings(experiment: ExperimentConfig, judgement: Judgement, rules: Rules) -> dict[str, Any]:
    """Keys of a detector that computes a judged score, with the threshold of the study."""
    made, scored = experiment.indicator_choice.made(experiment.wavelet), judgement.scored
    settings: dict[str, Any] = {
        "direction": str(judgement.direction),
        "false_alarm_rate": rules.false_alarm_rate,
        "confidence": rules.confidence,
        "threshold": rules.threshold,
        "chart": None,
        "compensate": False,
    }
    if scored.made_by is None:
        label, _, output = scored.name.partition(".")
        options = made[label].options.model_dump(mode="json")
        return settings | {"indicator": made[label].name, "options": options, "output": output}
    used = dict.fromkeys(name.partition(".")[0] for name in scored.numbers)
    indicators = stated_indicators({label: made[label] for label in used}, in_full=True)
    return settings | {"indicators": indicators, "score": scored.made_by.model_dump(mode="json")}


@dataclass(frozen=True, eq=False)
class Traces:
    """Score over time of records, without the initial transient of its estimator.

    Attributes
    ----------
    values : ndarray, shape (n_record, n_instant)
        [unit]; NaN after the estimator diverged.
    time : ndarray, shape (n_instant,)
        Instants [s], on the clock of the records.
    onset : ndarray, shape (n_record,)
        Onset of the leak of a record [s]; NaN if it exists from the start.
    flow : ndarray, shape (n_record,)
        True mean leakage flow from the onset on [m³/s]; NaN if the run failed.
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
    time = indicator.watched_instants(request.record.sampling_frequency, request.n_discarded)
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


def judge_chart(
    traces: Traces, label: str, asked: WatchedChart, online: OnlineConfig, rules: Rules
) -> Iterator[ChartJudgement]:
    """Evaluate a chart at each of its limits. Healthy fit records set the limits and are never tested."""
    chart = make_chart(asked.chart, {"direction": traces.direction} | asked.options)
    (population,) = traces.records.chosen(Kind.HEALTHY, is_fit=True)
    fit, fitted = traces.records.rows(population), None
    for every in online.false_alarm_every:
        judged, notes = ChartJudgement(label, asked.of, asked.chart, traces.unit, every), Notes()
        try:
            centre, spread = healthy_scale(traces.values[fit])
            scores = (traces.values - centre) / spread
            fitted = fitted or FalseAlarms(chart, scores[fit], traces.interval)
            limit = fitted.limit(every, confidence=rules.confidence)
        except NotStatedError as refusal:
            yield replace(judged, refusals=(str(refusal),))
            continue
        yield replace(
            judged,
            centre=centre,
            spread=spread,
            limit=limit,
            outcomes=tuple(_outcomes(traces, scores, chart, limit.value, rules.confidence, notes)),
            refusals=tuple(notes.refusals),
        )


def _outcomes(
    traces: Traces, scores: Array, chart: Chart, limit: float, confidence: float, notes: Notes
) -> Iterator[Outcome[AlarmLimit | Delays]]:
    """False alarms, and delays of leaks with an onset while watched: none if leaks exist from the start."""
    records = traces.records
    for population in (tested for kind in SOUND for tested in records.chosen(kind, is_fit=False)):
        try:
            of = FalseAlarms(chart, scores[records.rows(population)], traces.interval)
            yield Outcome(population, 0.0, of.at(limit, confidence=confidence))
        except NotStatedError as refusal:
            notes.refusals.append(f"no false alarms are stated for {population.title} alone: {refusal}")
    for population in records.chosen(Kind.FAULT, is_fit=False):
        rows = records.rows(population)
        rows = rows[traces.sets_in[rows]]
        if rows.size:
            found = delays(chart, limit, scores[rows], traces.time, traces.onset[rows])
            yield Outcome(population, float(np.mean(traces.flow[rows])), found)


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


TRUTHS = {"internal_coefficient": LEAKAGE_COEFFICIENT, "bulk_modulus": BULK_MODULUS}
"""Output of an indicator → variable of the file with the true value of each run."""

ERROR = "_error"
"""Suffix of the output that contains the stated standard deviation of an estimate."""

FAULTS = "faults"
"""Name of the combination of all leaking test records."""


def estimated(data: ExperimentData) -> Iterator[tuple[str, str]]:
    """Name and quantity of each estimate whose truth is known: β has a single value if it is constant."""
    for name in data.columns:
        label, _, quantity = name.rpartition(".")
        has_truth = quantity == "internal_coefficient" or data.experiment.fluid.is_constant
        if label and quantity in TRUTHS and has_truth:
            yield name, quantity


def judge_estimates(data: ExperimentData, records: StudyRecords) -> list[dict[str, Any]]:
    """Evaluate every estimate of a design of a stored study, on test records and shifts.

    For each estimate and population: mean error, standard deviation of the errors, root mean square of the
    stated deviations, and the share of records whose stated interval contains the true value. Leaks with a
    later onset are excluded: such records have no single true value. So are estimates without a deviation.
    """
    populations = {
        each.name: records.rows(each)
        for kind in (Kind.HEALTHY, Kind.SHIFT)
        for each in records.chosen(kind, is_fit=False)
    }
    faults = records.chosen(Kind.FAULT, is_fit=False)
    if faults and data.experiment.leakage.onset == "constant":
        populations[FAULTS] = np.sort(np.concatenate([*map(records.rows, faults)]))
    lines = []
    for name, quantity in estimated(data):
        if (stated := data.columns.get(f"{name}{ERROR}")) is None:
            continue
        columns = (data.columns[TRUTHS[quantity]], data.columns[name], stated)
        truth, estimate, deviation = (np.asarray(own[records.runs], dtype=float) for own in columns)
        scale = truth if quantity == "bulk_modulus" else np.ones_like(truth)
        error, deviation = (estimate - truth) / scale, deviation / scale
        label, confidence = name.rpartition(".")[0], data.experiment.detection.confidence
        lines += [
            _row(label, quantity, population, error[rows], deviation[rows], confidence)
            for population, rows in populations.items()
        ]
    return lines


def _row(
    label: str, quantity: str, population: str, error: Array, stated: Array, confidence: float
) -> dict[str, Any]:
    known = np.isfinite(error) & np.isfinite(stated)
    width = NormalDist().inv_cdf(0.5 + confidence / 2.0)
    covered = alarm_rate(np.where(known, np.abs(error) <= width * stated, np.nan), confidence=confidence)
    own, deviations, n = error[known], stated[known], int(known.sum())
    numbers = {
        "mean_error": float(own.mean()) if n else None,
        "deviation": float(own.std(ddof=1)) if n > 1 else None,
        "stated_deviation": float(np.sqrt(np.mean(np.square(deviations)))) if n else None,
    }
    is_modulus = quantity == "bulk_modulus"
    unit = "percent" if is_modulus else "L_per_min"

    def shown(value: float) -> float:
        return 100.0 * value if is_modulus else convert(flow_at_reference(value), "L/min")

    return {
        "indicator": label,
        "quantity": "bulk_modulus" if is_modulus else "leakage",
        "population": population,
        "n": n,
        "not_measurable": int((~known).sum()),
        **{f"{name}_{unit}": None if each is None else shown(each) for name, each in numbers.items()},
        "covered": covered.value if n else None,
        "covered_low": covered.low,
        "covered_high": covered.high,
    }


_log = logging.getLogger(__name__)


def winner_settings(stored: ExperimentData, sensors: Sequence[str]) -> dict[str, Any]:
    """Settings of the winner of a study that needs no more than these sensors; all if none are named."""
    missing = int((stored.columns[STATUS].astype(str) == MISSING).sum())
    if missing:
        raise ReportError(
            f"{stored.path}: {counted(missing, 'run')} missing; sweep again to compute the rest"
        )
    try:
        channels = [Channel(name.strip()) for each in sensors for name in each.split(",")]
    except ValueError as error:
        known = ", ".join(channel.symbol for channel in Channel)
        raise ConfigError(f"sensors: {error}; known are {known}") from None
    detection = judge_study(stored)[0]
    best = winner(detection, channels)
    with_these = f" with {', '.join(each.symbol for each in channels)}" if channels else ""
    if channels and not any(within(each.scored, channels) for each in detection.judgements):
        raise ConfigError(f"sensors: the study has no score{with_these} alone")
    if best is None:
        rules = detection.rules
        n_fit, n_test = rules.records_for_threshold(Direction.BOTH), rules.records_for_false_alarms
        raise NotStatedError(
            f"{stored.path}: no score{with_these} is known to keep its false-alarm rate; to know it takes"
            f" study.healthy: {{fit: {n_fit}, test: {n_test}, shift: {n_test}}} or more, and to keep it a"
            " study.population that includes the shifts that are normal",
            n_test,
        )
    if not best.finds:
        _log.warning(f"{best.name} finds none of the tested leaks nine times in ten")
    study = stored.experiment.study
    is_drawn = study is not None and "wavelet.phase" in study.population.per_record
    if is_drawn and any(number.startswith("dwt.") for number in best.scored.numbers):
        _log.warning(
            f"{best.name}: the study draws the start phase of the wavelet, windows of a detector all"
            " start at one, so its rates may differ; wavelet: {phase: 0} in the study makes them equal"
        )
    return detector_settings(stored.experiment, best, detection.rules)
