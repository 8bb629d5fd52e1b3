"""A judged study as lines of a table: one line per score and tested population, units in the header."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from hydrofdi.evaluation.populations import Population
from hydrofdi.report.detection.record import alarms_of, design_record
from hydrofdi.report.detection.selection import level_of
from hydrofdi.report.detection.wording import severity_unit
from hydrofdi.report.forms.numbers import finite
from hydrofdi.studies.judgement import Detection, Judgement


def detection_lines(detections: Sequence[Detection]) -> Iterator[dict[str, Any]]:
    """Header → value, line by line; None if a number is missing."""
    for detection in detections:
        yield from _lines(detection)


def _lines(detection: Detection) -> Iterator[dict[str, Any]]:
    for judgement in detection.judgements:
        lead, end = _lead(detection, judgement), _end(detection, judgement)
        populations: list[Population | None] = [*alarms_of(judgement)]
        for population in populations or [None]:
            yield lead | _population_record(detection, judgement, population) | end


def _lead(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    threshold = judgement.threshold
    return {
        **design_record(detection),
        "indicator": judgement.scored.name,
        "channels": " ".join(judgement.scored.channels),
        "unit": judgement.scored.unit,
        "direction": str(judgement.direction),
        "threshold_low": None if threshold is None else finite(threshold.low),
        "threshold_high": None if threshold is None else finite(threshold.high),
        "false_alarm_rate_set": detection.rules.false_alarm_rate,
    }


def _population_record(
    detection: Detection, judgement: Judgement, population: Population | None
) -> dict[str, Any]:
    unit = severity_unit(detection)
    if population is None:
        keys = ("population", "kind", unit.key, "alarms", "n", "not_measurable", "rate", "low", "high")
        return dict.fromkeys((*keys, "auc", "auc_low", "auc_high"))
    rate, level = alarms_of(judgement)[population], level_of(judgement, population)
    stated = (None,) * 3 if population in judgement.counted else (rate.value, rate.low, rate.high)
    area = None if level is None else level.area
    areas = (None,) * 3 if area is None else (area.value, area.low, area.high)
    numbers = dict(zip(("rate", "low", "high", "auc", "auc_low", "auc_high"), (*stated, *areas), strict=True))
    return {
        "population": population.name,
        "kind": str(population.kind),
        unit.key: unit.value(population.severity),
        "alarms": rate.count,
        "n": rate.total,
        "not_measurable": rate.not_measurable,
        **{key: None if value is None else finite(value) for key, value in numbers.items()},
    }


def _end(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    unit, cost = severity_unit(detection), judgement.scored.cost
    found = {name: judgement.smallest.get(name) for name in ("q50", "q90", "q90_95", "q90_95_of_all")}
    return {
        **{
            f"{name}{unit.suffix}": None if one is None or one.value is None else unit.value(one.value)
            for name, one in found.items()
        },
        "q90_95_place": None if found["q90_95"] is None else found["q90_95"].place,
        "q90_95_from": None if found["q90_95"] is None else found["q90_95"].source,
        "keeps_false_alarm_rate": None if judgement.keeps_its_rate is None else int(judgement.keeps_its_rate),
        "is_in_pareto_set": int(judgement.scored.name in detection.pareto),
        "cost_ms_per_record": None if cost is None else finite(1e3 * cost),
    }
