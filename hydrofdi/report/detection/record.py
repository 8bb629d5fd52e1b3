"""A judged study as plain data: its scores, its designs side by side, and tables of labelled records."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from hydrofdi.config.values import shown_value
from hydrofdi.evaluation.scores import Kind, Population, comparable
from hydrofdi.report.detection import wording
from hydrofdi.report.detection.populations import nuisance_records
from hydrofdi.report.detection.wording import FROM_LEVELS, severity_unit
from hydrofdi.report.document import Block
from hydrofdi.settings.messages import HOLE, counted, number_text, percentage
from hydrofdi.studies.records import LEAST_OF_GROUP, Detection, Judgement
from hydrofdi.tables.table import Column, Table, finite, group_breaks, numbers

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
    columns = [Column("Design", [_label(detections, each) for each in detections], is_text=True)]
    for name in [*dict.fromkeys(name for row in rows for name in row)][:_MOST]:
        found = [each.smallest.get("q90_95") if (each := row.get(name)) else None for row in rows]
        columns.append(Column(name, [*map(unit.found, found)]))
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
    found = judgement.smallest.get(name)
    value = None if found is None or found.value is None else unit.value(found.value)
    return value, found and found.place, found and found.source


def conclusion(detection: Detection) -> str:
    """Comparison of healthy groups over all scores; empty if there are fewer than two and a fault."""
    judgements = [each for each in detection.judgements if each.levels]
    known = [each.stands_clear for each in judgements if each.stands_clear is not None]
    n_not, n_score = known.count(False), len(known)
    if not judgements:
        return "no record is labelled faulty, so no detection can be stated"
    if not n_score:
        few = f"fewer than two healthy groups have {LEAST_OF_GROUP} records: whether only the unit or the day"
        has_groups = any(each.healthy_pairs for each in detection.judgements)
        return f"{few} was detected cannot be told" if has_groups else ""
    if not n_not:
        return "in every score, faults differ more from healthy records than healthy groups do"
    return (
        f"{'only' if n_not == n_score else 'perhaps only'} the unit or the day was detected: in {n_not} of"
        f" {counted(n_score, 'score')}, marked ~, healthy groups differ from each other as much as faults"
        " differ from them"
    )


def labelled_table(detection: Detection) -> Table:
    """A row for each score and population with the numbers of CSV, the best score first."""
    unit, by_name = severity_unit(detection), {each.scored.name: each for each in detection.judgements}
    found = f"q90_95{unit.suffix}"
    titles = {
        "indicator": "score",
        "population": "population",
        "alarms": "alarms",
        "auc": "AUC",
        found: f"q90/95{unit.bracket}",
        "not_measurable": "without a number",
    }

    def text_of(line: dict[str, Any], name: str) -> str:
        judgement = by_name[line["indicator"]]
        if name == "indicator":
            return f"{'~ ' if judgement.stands_clear is False else ''}{line[name]}"
        if name == "alarms" and line["n"] is not None:
            ends = [percentage(line[end]) for end in ("rate", "low", "high") if line[end] is not None]
            share = ", {} % [{}, {}]".format(*ends) if len(ends) == 3 else ""
            return f"{line['alarms']} of {line['n']}{share}"
        if name == "auc" and line["kind"] == Kind.HEALTHY and (areas := judgement.healthy_areas):
            return f"{min(areas):.2f} … {max(areas):.2f}"
        if name == "auc" and line["auc"] is not None:
            return _area_text(line["auc"], line["auc_low"], line["auc_high"])
        if name == found and line["kind"] == Kind.FAULT:
            return unit.found(judgement.smallest.get("q90_95")).removesuffix(FROM_LEVELS)
        return str(line[name]) if name in ("population", "not_measurable") and line[name] else HOLE

    lines = [line for line in detection_lines([detection]) if "population" in line]
    columns = []
    for name in [*titles, *(each for each in (lines[0] if lines else ()) if each not in titles)]:
        texts = [text_of(line, name) for line in lines]
        column = Column(name, [line[name] for line in lines], title=titles.get(name, ""), text=texts)
        is_text, is_shown = name in ("indicator", "population"), name in titles and {*texts} != {HOLE}
        columns.append(replace(column, is_text=is_text, is_shown=is_shown))
    breaks = group_breaks([line["indicator"] for line in lines])
    return Table(tuple(columns), n_lead=2, breaks=breaks if len(lines) > 2 * len(by_name) else ())


def pairs_table(detection: Detection) -> Table:
    """A row for two healthy groups, those first that the best score tells apart best.

    The threshold of ``fit_group`` is tested on ``test_group``. If no alarms are counted, both groups are
    listed once, and the second reads higher.
    """
    best = next(iter(detection.judgements), None)
    pairs = [] if best is None else list(best.healthy_pairs)
    pairs.sort(key=lambda pair: -abs(comparable(pair.area.value - 0.5)))
    has_alarms = any(pair.rate is not None for pair in pairs)
    if not has_alarms:
        pairs = [each for each in pairs if (each.area.value, each.fit_group) > (0.5, each.test_group)]
    titles = ("threshold of", "tested") if has_alarms else ("group", "reads higher")
    areas, rates = [pair.area for pair in pairs], [pair.rate for pair in pairs]
    texts = [_area_text(area.value, area.low, area.high) for area in areas]
    return Table(
        (
            Column("fit_group", [pair.fit_group for pair in pairs], title=titles[0], is_text=True),
            Column("test_group", [pair.test_group for pair in pairs], title=titles[1], is_text=True),
            Column("auc", [area.value for area in areas], title="AUC", text=texts),
            Column("auc_low", [area.low for area in areas], is_shown=False),
            Column("auc_high", [area.high for area in areas], is_shown=False),
            Column("alarms", [r and r.count for r in rates], title="false alarms", is_shown=has_alarms),
            Column("n", [r and r.total for r in rates], title="of", is_shown=has_alarms),
        ),
        title=f"Healthy groups against each other by {best.scored.name if best else ''}: none of them leaks",
        n_lead=2,
    )


def _area_text(value: float, low: float, high: float) -> str:
    return f"{number_text(value, 2)} [{number_text(low, 2)}, {number_text(high, 2)}]"
