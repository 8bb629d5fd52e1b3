"""An evaluation of labelled records as plain data for JSON; numbers that do not exist are None."""

from __future__ import annotations

from typing import Any

from hydrofdi.api.evaluate_records import Evaluation
from hydrofdi.api.healthy_control import stands_clear
from hydrofdi.evaluation.auc import Area
from hydrofdi.evaluation.groups import HealthyPair
from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.report.forms.numbers import finite
from hydrofdi.studies.judgement import Judgement
from hydrofdi.studies.parts import records_without_number
from hydrofdi.units import convert


def evaluation_record(evaluation: Evaluation) -> dict[str, Any]:
    """What was judged, how, and what every score finds, the best first."""
    detection = evaluation.detection
    records, rules = detection.records, detection.rules
    return {
        "false_alarm_rate_set": rules.false_alarm_rate,
        "confidence": rules.confidence,
        "probability": rules.probability,
        "records": evaluation.left.n_record,
        "rejected": evaluation.left.n_rejected,
        "repeated": evaluation.left.n_repeated,
        "groups": None if records.groups is None else sorted(set(records.groups)),
        "populations": [
            {"label": each.name, "is_healthy": each.kind == "healthy", "n": records.rows(each).size}
            for each in records.populations
        ],
        "conclusion": evaluation.conclusion or None,
        "remarks": list(detection.remarks),
        "scores": [_score_record(evaluation, each) for each in detection.judgements],
    }


def _score_record(evaluation: Evaluation, judgement: Judgement) -> dict[str, Any]:
    scored, threshold = judgement.scored, judgement.threshold
    bound = judgement.smallest.get("q90_95")
    found = None if bound is None else bound.value
    return {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": None
        if threshold is None
        else {"low": finite(threshold.low), "high": finite(threshold.high), "n": threshold.n_healthy},
        "false_alarms": [
            _rate_record(judgement, each, rate) for each, rate in judgement.false_alarms.items()
        ],
        "auc": [
            {"label": level.population.name} | _area_record(level.area)
            for level in judgement.levels
            if level.area is not None
        ],
        "detected": [
            _rate_record(judgement, level.population, level.detected)
            for level in judgement.levels
            if level.detected is not None
        ],
        "q90_95_L_per_min": None if found is None else convert(found, "L/min"),
        "stands_clear": stands_clear(judgement, evaluation.healthy_pairs[scored.name]),
        "without_number": records_without_number(evaluation.detection.records, scored),
        "healthy_against_healthy": [_pair_record(each) for each in evaluation.healthy_pairs[scored.name]],
        "refusals": list(judgement.refusals),
        "remarks": list(judgement.remarks),
        "note": scored.note or None,
    }


def _area_record(area: Area) -> dict[str, Any]:
    numbers = {"value": area.value, "low": area.low, "high": area.high}
    return {name: finite(value) for name, value in numbers.items()} | {
        "n_healthy": area.n_healthy,
        "n": area.n_faulty,
    }


def _rate_record(judgement: Judgement, population: Population, rate: Rate) -> dict[str, Any]:
    """Alarms of a population; a rate where there are enough records for one."""
    needed = judgement.counted.get(population)
    stated = [None if needed else finite(value) for value in (rate.value, rate.low, rate.high)]
    return {
        "label": population.name,
        "alarms": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
        **dict(zip(("rate", "low", "high"), stated, strict=True)),
        "records_needed": needed,
    }


def _pair_record(pair: HealthyPair) -> dict[str, Any]:
    alarms = None if pair.rate is None else pair.rate.count
    return (
        {"fit_group": pair.fit_group, "test_group": pair.test_group}
        | _area_record(pair.area)
        | {"alarms": alarms, "refusal": pair.refusal or None}
    )
