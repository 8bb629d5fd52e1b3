"""A judged study as plain data, and its designs side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.config.values import shown_value
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.report.detection import wording
from hydrofdi.report.detection.populations import nuisance_records
from hydrofdi.report.document import Block
from hydrofdi.studies.records import Detection, Judgement
from hydrofdi.tables.table import Column, Table, finite, numbers

_FOUND = ("q50", "q90", "q90_95", "q90_95_of_all")
_RATE = {"rate": "value", "low": "low", "high": "high"}
_AREA = {"": "value", "_low": "low", "_high": "high"}
_ALARMS = ("population", "kind", "rate", "low", "high", "alarms", "n", "not_measurable")


def detection_records(detection: Detection) -> list[dict[str, Any]]:
    """One record for each score, the best first."""
    return [_record(detection, judgement) for judgement in detection.judgements]


def study_record(detection: Detection) -> dict[str, Any]:
    """What belongs to all scores: what is asked, the populations, the remarks."""
    asked, records, unit = detection.rules, detection.records, wording.severity_unit(detection)
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
                unit.key: stated_severity(unit, population),
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


def _record(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    unit, scored, threshold = wording.severity_unit(detection), judgement.scored, judgement.threshold
    lines = [*_populations(detection, judgement)]
    records, n_sound = detection.records, len(judgement.false_alarms)
    is_labelled = records.is_labelled
    levels = [
        (level, line, {"population": line["population"]} if is_labelled else {})
        for level, line in zip(judgement.levels, lines[n_sound:], strict=True)
    ]
    record: dict[str, Any] = {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": threshold
        and numbers(threshold, "low", "high")
        | {"method": threshold.method, "n": threshold.n_healthy, "not_measurable": threshold.not_measurable},
        "false_alarm_rate_set": detection.rules.false_alarm_rate,
        "false_alarms": [{name: line[name] for name in _ALARMS} for line in lines[:n_sound]],
        "keeps_false_alarm_rate": judgement.keeps_its_rate,
        "auc": [
            {**named, unit.key: line[unit.key]} | numbers(level.area, "value", "low", "high")
            for level, line, named in levels
            if level.area is not None
        ],
        "pod": [
            {
                **named,
                unit.key: line[unit.key],
                f"true_mean_{unit.key}": finite(unit.value(level.severity)),
                "detected": line["alarms"],
                **{name: line[name] for name in ("n", "not_measurable")},
                **({name: line[name] for name in _RATE} if is_labelled else {}),
            }
            for level, line, named in levels
            if level.detected is not None
        ],
        "lack_of_fit_p_value": finite(judgement.lack_of_fit),
        "is_in_pareto_set": scored.name in detection.pareto,
        "cost_ms_per_record": None if scored.cost is None else finite(1e3 * scored.cost),
        "design": design_record(detection),
        "nuisances": nuisance_records(detection, scored.name),
        "refusals": list(judgement.refusals),
        "remarks": [*judgement.remarks, *([scored.note] if scored.note else [])],
    }
    for name in _FOUND:
        keys = (f"{name}{unit.suffix}", f"{name}_place", f"{name}_from")
        record |= zip(keys, _found(judgement, name, unit), strict=True)
    if is_labelled:
        missing = {each.name: records.n_missing(scored, each) for each in records.populations}
        record["without_number"] = {name: count for name, count in missing.items() if count}
        record["stands_clear"] = judgement.stands_clear
        record["healthy_against_healthy"] = [
            {"fit_group": each.fit_group, "test_group": each.test_group}
            | numbers(each.area, "value", "low", "high")
            | {"n_healthy": each.area.n_healthy, "n": each.area.n_faulty}
            | {"alarms": each.rate and each.rate.count, "refusal": each.refusal or None}
            for each in judgement.healthy_pairs
        ]
    return record


def stated_severity(unit: wording.SeverityUnit, population: Population) -> float | None:
    """Nominal severity; None if a label does not state that of its fault."""
    is_unknown = population.kind is Kind.FAULT and not population.severity
    return None if is_unknown else unit.value(population.severity)


def detection_lines(detections: Sequence[Detection]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each score and tested population, with the numbers of JSON."""
    for detection in detections:
        unit = wording.severity_unit(detection)
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
    """Alarms of every population, sound ones that are tested and leaking; a rate if the records suffice."""
    unit, records = wording.severity_unit(detection), detection.records
    levels = {level.population: level for level in judgement.levels}
    rates = {**judgement.false_alarms, **{population: each.detected for population, each in levels.items()}}
    for population, rate in rates.items():
        area = levels[population].area if population in levels else None
        has_rate = rate is not None and population not in judgement.counted
        yield {
            "population": population.name,
            "kind": str(population.kind),
            unit.key: stated_severity(unit, population),
            "alarms": rate and rate.count,
            "n": rate and rate.total,
            "not_measurable": records.n_missing(judgement.scored, population),
            **{name: finite(getattr(rate, end)) if has_rate else None for name, end in _RATE.items()},
            **{f"auc{end}": area and finite(getattr(area, name)) for end, name in _AREA.items()},
        }


_MOST = 6
"""Columns of detectors."""


def designs_block(detections: Sequence[Detection]) -> Block | None:
    """What each design finds with each set of sensors; None for a single design."""
    if len(detections) < 2:
        return None
    unit, rules = wording.severity_unit(detections[0]), detections[0].rules
    sentence = (
        "Each design repeats the study with the same actuators. Columns: the best score with no more than"
        " these sensors in each design, and the wavelet rules."
    )
    title = f"q{100.0 * rules.probability:g}/{100.0 * rules.confidence:g}{unit.bracket}"
    rows = [_columns(detection) for detection in detections]
    columns = [Column("Design", [_label(detections, detection) for detection in detections], is_text=True)]
    for name in [*dict.fromkeys(name for row in rows for name in row)][:_MOST]:
        bounds = [each.smallest.get("q90_95") if (each := row.get(name)) else None for row in rows]
        columns.append(Column(name, [*map(unit.found, bounds)]))
    table = Table(tuple(columns), title, "designs", breaks=(1,))
    return Block("designs", "Comparison of designs", (sentence,), (table,))


def _columns(detection: Detection) -> dict[str, Judgement]:
    names = {frozenset(each.scored.channels): wording.sensors(each) for each in detection.judgements}
    best = {names[channels]: each for channels, each in wording.best_with_sensors(detection).items()}
    return best | {each.scored.name: each for each in wording.wavelet_rules(detection)}


def _label(detections: Sequence[Detection], detection: Detection) -> str:
    """What a design changes of the first one, which is named by what it sets."""
    own, first = detection.records.design, detections[0].records.design
    names: dict[str, list[str]] = defaultdict(list)
    for name, value in own.items():
        if detection is detections[0] or first.get(name) != value:
            names[shown_value(name, value)].append(name)
    return ", ".join(f"{', '.join(alike)} = {value}" for value, alike in names.items()) or "as configured"


def _found(judgement: Judgement, name: str, unit: wording.SeverityUnit) -> tuple[Any, ...]:
    """A severity that is found, on which side of the tested ones it lies, and what it is from."""
    bound = judgement.smallest.get(name)
    value = None if bound is None or bound.value is None else unit.value(bound.value)
    return value, bound and bound.place, bound and bound.source
