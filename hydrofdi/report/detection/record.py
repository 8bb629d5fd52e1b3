"""A judged study as plain data for JSON; numbers that do not exist are None."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hydrofdi.evaluation.pod.detectable import DetectableSeverity
from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.evaluation.threshold import Threshold
from hydrofdi.report.detection.nuisances import nuisance_records
from hydrofdi.report.detection.wording import SeverityUnit, severity_unit
from hydrofdi.report.forms.numbers import finite
from hydrofdi.studies.judgement import Detection, Judgement, Level


def detection_records(detection: Detection) -> list[dict[str, Any]]:
    """One record for each score, the best first."""
    return [_judgement_record(detection, judgement) for judgement in detection.judgements]


def study_record(detection: Detection) -> dict[str, Any]:
    """What belongs to all scores: what is asked, the populations, the remarks."""
    asked, records, unit = detection.rules, detection.records, severity_unit(detection)
    return {
        "false_alarm_rate_set": asked.false_alarm_rate,
        "confidence": asked.confidence,
        "probability": asked.probability,
        "design": design_record(detection),
        "populations": [
            {
                "population": population.name,
                "kind": str(population.kind),
                "is_fit": population.is_fit,
                "n": len(records.rows(population)),
                unit.key: unit.value(population.severity),
            }
            for population in records.populations
        ],
        "remarks": list(detection.remarks),
    }


def design_record(detection: Detection) -> dict[str, Any]:
    """What was chosen for all records alike, in SI."""
    return {
        name: finite(value) if isinstance(value, float) else value
        for name, value in detection.records.design.items()
    }


def _judgement_record(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    unit, scored = severity_unit(detection), judgement.scored
    return {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": _threshold_record(judgement.threshold),
        "false_alarm_rate_set": detection.rules.false_alarm_rate,
        "false_alarms": [
            {"population": population.name, "kind": str(population.kind)}
            | _rate_record(rate, is_counted=population in judgement.counted)
            for population, rate in judgement.false_alarms.items()
        ],
        "keeps_false_alarm_rate": judgement.keeps_its_rate,
        "auc": [_area_record(level, unit) for level in judgement.levels if level.area is not None],
        "partial_auc": finite(judgement.partial_area),
        "pod": [_level_record(level, unit) for level in judgement.levels if level.detected is not None],
        **_found_record(judgement.smallest, unit),
        "lack_of_fit_p_value": finite(judgement.lack_of_fit.p_value) if judgement.lack_of_fit else None,
        "is_in_pareto_set": scored.name in detection.pareto,
        "cost_ms_per_record": None if scored.cost is None else finite(1e3 * scored.cost),
        "design": design_record(detection),
        "nuisances": nuisance_records(detection, judgement),
        "refusals": list(judgement.refusals),
        "remarks": [*judgement.remarks, *([scored.note] if scored.note else [])],
    }


def _threshold_record(threshold: Threshold | None) -> dict[str, Any] | None:
    if threshold is None:
        return None
    return {
        "low": finite(threshold.low),
        "high": finite(threshold.high),
        "method": threshold.method,
        "n": threshold.n_healthy,
        "not_measurable": threshold.not_measurable,
    }


def _rate_record(rate: Rate, *, is_counted: bool) -> dict[str, Any]:
    """A rate; of too few records for one the numbers alone."""
    stated = [None if is_counted else finite(value) for value in (rate.value, rate.low, rate.high)]
    return {
        **dict(zip(("rate", "low", "high"), stated, strict=True)),
        "alarms": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
    }


def _area_record(level: Level, unit: SeverityUnit) -> dict[str, Any]:
    area = level.area
    assert area is not None
    return {
        unit.key: unit.value(level.population.severity),
        "value": finite(area.value),
        "low": finite(area.low),
        "high": finite(area.high),
    }


def _level_record(level: Level, unit: SeverityUnit) -> dict[str, Any]:
    rate = level.detected
    assert rate is not None
    return {
        unit.key: unit.value(level.population.severity),
        f"true_mean_{unit.key}": finite(unit.value(level.severity)),
        "detected": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
    }


def _found_record(smallest: Mapping[str, DetectableSeverity], unit: SeverityUnit) -> dict[str, Any]:
    """Severities that are found, on which side of the tested ones they lie, and where they come from."""
    record: dict[str, Any] = {}
    for name in ("q50", "q90", "q90_95", "q90_95_of_all"):
        found = smallest.get(name)
        value = None if found is None else found.value
        record[f"{name}{unit.suffix}"] = None if value is None else unit.value(value)
        record[f"{name}_place"] = None if found is None else found.place
        record[f"{name}_from"] = None if found is None else found.source
    return record


def alarms_of(judgement: Judgement) -> dict[Population, Rate]:
    """Rates of alarms of every population that is tested, sound and leaking."""
    detected = {level.population: level.detected for level in judgement.levels if level.detected is not None}
    return {**judgement.false_alarms, **detected}
