"""A judged study as plain data for JSON, and as lines of CSV; numbers that do not exist are None."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.evaluation.populations import Population
from hydrofdi.evaluation.rates import Rate
from hydrofdi.report.detection.nuisances import nuisance_records
from hydrofdi.report.detection.selection import level_of
from hydrofdi.report.detection.wording import severity_unit
from hydrofdi.report.table import finite
from hydrofdi.studies.charts import RunLengths
from hydrofdi.studies.judgement import Detection, Judgement

_FOUND = ("q50", "q90", "q90_95", "q90_95_of_all")
_ALARMS = ("population", "kind", "rate", "low", "high", "alarms", "n", "not_measurable")


def detection_records(detection: Detection) -> list[dict[str, Any]]:
    """One record for each score, the best first."""
    return [_record(detection, judgement) for judgement in detection.judgements]


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


def design_record(study: Detection | RunLengths) -> dict[str, Any]:
    """What was chosen for all records alike, in SI."""
    return {
        name: finite(value) if isinstance(value, float) else value
        for name, value in study.records.design.items()
    }


def _record(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    unit, scored, threshold = severity_unit(detection), judgement.scored, judgement.threshold
    lines = [*_populations(detection, judgement)]
    n_sound = len(judgement.false_alarms)
    record: dict[str, Any] = {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": threshold
        and {
            "low": finite(threshold.low),
            "high": finite(threshold.high),
            "method": threshold.method,
            "n": threshold.n_healthy,
            "not_measurable": threshold.not_measurable,
        },
        "false_alarm_rate_set": detection.rules.false_alarm_rate,
        "false_alarms": [{name: line[name] for name in _ALARMS} for line in lines[:n_sound]],
        "keeps_false_alarm_rate": judgement.keeps_its_rate,
        "auc": [
            {
                unit.key: unit.value(level.population.severity),
                "value": finite(level.area.value),
                "low": finite(level.area.low),
                "high": finite(level.area.high),
            }
            for level in judgement.levels
            if level.area is not None
        ],
        "partial_auc": finite(judgement.partial_area),
        "pod": [
            {
                unit.key: unit.value(level.population.severity),
                f"true_mean_{unit.key}": finite(unit.value(level.severity)),
                "detected": level.detected.count,
                "n": level.detected.total,
                "not_measurable": level.detected.not_measurable,
            }
            for level in judgement.levels
            if level.detected is not None
        ],
        "lack_of_fit_p_value": finite(judgement.lack_of_fit.p_value) if judgement.lack_of_fit else None,
        "is_in_pareto_set": scored.name in detection.pareto,
        "cost_ms_per_record": None if scored.cost is None else finite(1e3 * scored.cost),
        "design": design_record(detection),
        "nuisances": nuisance_records(detection, scored.name),
        "refusals": list(judgement.refusals),
        "remarks": [*judgement.remarks, *([scored.note] if scored.note else [])],
    }
    for name in _FOUND:
        found = judgement.smallest.get(name)
        value = None if found is None else found.value
        record[f"{name}{unit.suffix}"] = None if value is None else unit.value(value)
        record[f"{name}_place"] = found and found.place
        record[f"{name}_from"] = found and found.source
    return record


def detection_lines(detections: Sequence[Detection]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each score and tested population, with the numbers of JSON."""
    for detection in detections:
        unit = severity_unit(detection)
        names = [*(f"{name}{unit.suffix}" for name in _FOUND), "q90_95_place", "q90_95_from"]
        for judgement in detection.judgements:
            record = _record(detection, judgement)
            limits, keeps = record["threshold"] or {}, record["keeps_false_alarm_rate"]
            lead = record["design"] | {
                "indicator": record["indicator"],
                "channels": " ".join(record["channels"]),
                "unit": record["unit"],
                "direction": record["direction"],
                "threshold_low": limits.get("low"),
                "threshold_high": limits.get("high"),
                "false_alarm_rate_set": record["false_alarm_rate_set"],
            }
            end = {name: record[name] for name in names} | {
                "keeps_false_alarm_rate": None if keeps is None else int(keeps),
                "is_in_pareto_set": int(record["is_in_pareto_set"]),
                "cost_ms_per_record": record["cost_ms_per_record"],
            }
            for line in [*_populations(detection, judgement)] or [{}]:
                yield lead | line | end


def _populations(detection: Detection, judgement: Judgement) -> Iterator[dict[str, Any]]:
    """Alarms of every population that is tested, sound and leaking; a rate where the records suffice."""
    unit = severity_unit(detection)
    detected = {level.population: level.detected for level in judgement.levels if level.detected is not None}
    rates: dict[Population, Rate] = {**judgement.false_alarms, **detected}
    for population, rate in rates.items():
        level = level_of(judgement, population)
        area = level and level.area
        ends = [rate.value, rate.low, rate.high] if population not in judgement.counted else [None] * 3
        areas = [area.value, area.low, area.high] if area else [None] * 3
        names = ("rate", "low", "high", "auc", "auc_low", "auc_high")
        yield {
            "population": population.name,
            "kind": str(population.kind),
            unit.key: unit.value(population.severity),
            "alarms": rate.count,
            "n": rate.total,
            "not_measurable": rate.not_measurable,
            **{k: None if v is None else finite(v) for k, v in zip(names, (*ends, *areas), strict=True)},
        }
