"""A judged study as plain data: its scores, its charts, and what belongs to all of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from hydrofdi.detectors.charts import AlarmLimit
from hydrofdi.evaluation.scores import Kind, Population
from hydrofdi.report.detection import wording
from hydrofdi.settings.messages import convert
from hydrofdi.studies.records import ChartJudgement, Detection, Judgement, Nuisance, Outcome, nuisances_of
from hydrofdi.tables.table import finite, numbers, plain

_FOUND = ("q50", "q90", "q90_95", "q90_95_of_all")
_INTERVAL = ("value", "low", "high")
_ALARMS = ("population", "kind", "rate", "low", "high", "alarms", "n", "not_measurable")

_LEAD = ("indicator", "channels", "unit", "direction")
_ENDS = ("keeps_false_alarm_rate", "is_in_pareto_set", "cost_ms_per_record")


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
                unit.key: _stated_severity(unit, population),
            }
            for population in records.populations
        ],
        "remarks": list(detection.remarks),
    }


def design_record(detection: Detection) -> dict[str, Any]:
    """What was chosen for all records alike, in SI."""
    record: dict[str, Any] = plain(detection.records.design)
    return record


def _record(detection: Detection, judgement: Judgement) -> dict[str, Any]:
    unit, scored, threshold = wording.severity_unit(detection), judgement.scored, judgement.threshold
    records = detection.records
    lines = [_outcome_record(detection, judgement, outcome) for outcome in judgement.outcomes]
    levels = [
        (level, line, {name: line[name] for name in ("population", unit.key)})
        for level, line in zip(judgement.outcomes, lines, strict=True)
        if level.population.kind is Kind.FAULT
    ]
    missing = {each.name: records.n_missing(scored, each) for each in records.populations}
    record: dict[str, Any] = {
        "indicator": scored.name,
        "channels": list(scored.channels),
        "unit": scored.unit,
        "direction": str(judgement.direction),
        "threshold": threshold
        and numbers(threshold, "low", "high")
        | {"method": threshold.method, "n": threshold.n_healthy, "not_measurable": threshold.not_measurable},
        "false_alarm_rate_set": detection.rules.false_alarm_rate,
        "false_alarms": [
            {name: line[name] for name in _ALARMS} for line in lines if line["kind"] != Kind.FAULT
        ],
        "keeps_false_alarm_rate": judgement.keeps_its_rate,
        "auc": [
            named | numbers(level.area, *_INTERVAL) for level, _, named in levels if level.area is not None
        ],
        "pod": [
            {
                **named,
                f"true_mean_{unit.key}": finite(unit.value(level.severity)),
                "detected": line["alarms"],
                **{name: line[name] for name in ("n", "not_measurable", "rate", "low", "high")},
            }
            for level, line, named in levels
            if level.found is not None
        ],
        "lack_of_fit_p_value": finite(judgement.lack_of_fit),
        "is_in_pareto_set": scored.name in detection.pareto,
        "cost_ms_per_record": None if scored.cost is None else finite(1e3 * scored.cost),
        "design": design_record(detection),
        "nuisances": nuisance_records(detection, scored.name),
        "refusals": list(judgement.refusals),
        "remarks": [*judgement.remarks, *([scored.note] if scored.note else [])],
        "without_number": {name: count for name, count in missing.items() if count},
        "stands_clear": judgement.stands_clear,
        "healthy_against_healthy": [
            {"fit_group": each.fit_group, "test_group": each.test_group}
            | numbers(each.area, *_INTERVAL)
            | {"n_healthy": each.area.n_healthy, "n": each.area.n_faulty}
            | {"alarms": each.rate and each.rate.count, "refusal": each.refusal or None}
            for each in judgement.healthy_pairs
        ],
    }
    for name in _FOUND:
        bound = judgement.smallest.get(name)
        value = None if bound is None or bound.value is None else unit.value(bound.value)
        record[f"{name}{unit.suffix}"] = value
        # On which side of the tested severities it lies, and what it is from.
        record |= {f"{name}_place": bound and bound.place, f"{name}_from": bound and bound.source}
    return record


@lru_cache(maxsize=1024)
def nuisances(detection: Detection, score: str) -> tuple[list[Nuisance], list[str]]:
    """The nuisances of a score by its name, and what is refused; empty without records for them."""
    (scored,) = (judgement.scored for judgement in detection.judgements if judgement.name == score)
    return nuisances_of(detection.records, scored, confidence=detection.rules.confidence)


def nuisance_records(detection: Detection, score: str) -> list[dict[str, Any]]:
    """The nuisances of a score as plain data; empty if the study has no records for them."""
    unit = wording.severity_unit(detection)
    return [
        {
            "parameter": each.parameter,
            "alone": each.alone and numbers(each.alone, "value", "low", "high") | {"n": each.alone.n_record},
            "imitates": each.imitated
            and {"place": each.imitated.place, unit.key: unit.value(each.imitated.severity)},
        }
        for each in nuisances(detection, score)[0]
    ]


def _stated_severity(unit: wording.SeverityUnit, population: Population) -> float | None:
    """Nominal severity; None if a label does not state that of its fault."""
    is_unknown = population.kind is Kind.FAULT and not population.severity
    return None if is_unknown else unit.value(population.severity)


def detection_lines(detections: Sequence[Detection]) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each score and tested population, with the numbers of JSON."""
    for detection in detections:
        unit = wording.severity_unit(detection)
        ends = [*(f"{name}{unit.suffix}" for name in _FOUND), "q90_95_place", "q90_95_from", *_ENDS]
        for judgement in detection.judgements:
            record = _record(detection, judgement)
            limits = record["threshold"] or {}
            lead = record["design"] | {name: record[name] for name in _LEAD}
            lead |= {"channels": " ".join(record["channels"])}
            lead |= {f"threshold_{end}": limits.get(end) for end in ("low", "high")}
            lead["false_alarm_rate_set"] = record["false_alarm_rate_set"]
            values = {name: record[name] for name in ends}
            end = {name: int(own) if isinstance(own, bool) else own for name, own in values.items()}
            for outcome in judgement.outcomes:
                yield lead | _outcome_record(detection, judgement, outcome) | end
            if not judgement.outcomes:
                yield lead | end


def _outcome_record(detection: Detection, judgement: Judgement, outcome: Outcome[Any]) -> dict[str, Any]:
    """Alarms of a population, a rate if the records suffice, and the area of a leak."""
    unit, population, rate = wording.severity_unit(detection), outcome.population, outcome.found
    return {
        "population": population.name,
        "kind": str(population.kind),
        unit.key: _stated_severity(unit, population),
        "alarms": rate and rate.count,
        "n": rate and rate.total,
        "not_measurable": detection.records.n_missing(judgement.scored, population),
        **_named(("rate", "low", "high"), None if outcome.is_counted else rate),
        **_named(("auc", "auc_low", "auc_high"), outcome.area),
    }


def _named(names: Sequence[str], interval: Any) -> dict[str, float | None]:
    """A value with the ends of its interval under these names; None if it is not stated."""
    ends = interval and numbers(interval, *_INTERVAL).values()
    return dict(zip(names, ends or (None,) * 3, strict=True))


def run_length_records(detections: Sequence[Detection]) -> list[dict[str, Any]]:
    """One record for each chart at each limit."""
    return [
        {
            **chart_record(chart),
            **numbers(chart, "centre", "spread"),
            "false_alarms": [line for line in _chart_lines(detection, chart) if "alarms" in line],
            "delays": [line for line in _chart_lines(detection, chart) if "found" in line],
            "design": design_record(detection),
            "refusals": list(chart.refusals),
        }
        for detection in detections
        for chart in detection.charts
    ]


def run_length_lines(detection: Detection) -> Iterator[dict[str, Any]]:
    """Header → value, one line for each chart, limit and tested population, and for each with a refusal."""
    for chart in detection.charts:
        yield from (chart_record(chart) | line for line in _chart_lines(detection, chart))
        if chart.refusals:
            yield chart_record(chart)


def chart_record(chart: ChartJudgement) -> dict[str, Any]:
    """What a chart is, and its limit."""
    return {
        "chart": chart.label,
        "rule": chart.rule,
        "indicator": chart.watched,
        "unit": chart.unit,
        "false_alarm_every_h": convert(chart.false_alarm_every, "h"),
        "limit": None if chart.limit is None else chart.limit.value,
    }


def _chart_lines(detection: Detection, chart: ChartJudgement) -> Iterator[dict[str, Any]]:
    """False alarms of each population, or delays of its leaks."""
    unit, asked = wording.severity_unit(detection), detection.rules
    late = f"delay_{100.0 * asked.probability:g}_percent"
    for outcome in chart.outcomes:
        population, found = outcome.population, outcome.found
        line: dict[str, Any] = {"population": population.name, "kind": str(population.kind)}
        line[unit.key] = unit.value(population.severity)
        if isinstance(found, AlarmLimit):
            line |= {"alarms": found.n_alarm, "hours": convert(found.duration, "h")}
            line |= _times("between_alarms", "h", found.mean_time, found.low, found.high)
            line["keeps_false_alarm_rate"] = chart.keeps(found)
        else:
            line |= {
                "true_mean_flow_after_onset_L_per_min": finite(convert(outcome.severity, "L/min")),
                "found": int(np.isfinite(found.values).sum()),
                "n": found.values.size,
                "false_alarms_before_onset": int(found.n_early.sum()),
                "not_measurable": found.not_measurable,
            }
            for name, share in (("delay_median", 0.5), (late, asked.probability)):
                delay = found.quantile(share, confidence=asked.confidence)
                line |= _times(name, "s", delay.value, delay.low, delay.high)
        yield line


def _times(name: str, unit: str, *times: float) -> dict[str, float | None]:
    """A time with its interval in a unit; None if there was no alarm in the records."""
    ends = zip(("", "_low", "_high"), times, strict=True)
    return {f"{name}{end}_{unit}": finite(convert(time, unit)) for end, time in ends}
