"""Tables of a judged study: all scores side by side, their false alarms, and what they detect."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.selection import chosen_levels, foremost, level_of, tested
from hydrofdi.report.detection.wording import FROM_LEVELS, percent, rate_text, sensors, severity_unit
from hydrofdi.report.table import Block, Column, Table
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.judgement import Detection, Judgement

KEEPING = {True: "", None: " ?", False: " !"}
"""Whether a score keeps its false-alarm rate → mark of its name."""

_MARKS = {"rising": "↑", "falling": "↓", "both": "↕"}
_MOST_ALARMS, _MOST_LEVELS = 20, 12


def ranking_block(detection: Detection) -> Block:
    """Every score that was tried."""
    unit, judgements, levels = severity_unit(detection), detection.judgements, chosen_levels(detection, 1)
    areas = [[level_of(each, level) for each in judgements] for level in levels]
    costs = [each.scored.cost for each in judgements]
    columns = (
        Column(
            "Score",
            [f"{e.scored.name} {_MARKS[e.direction]}{KEEPING[e.keeps_its_rate]}" for e in judgements],
            is_text=True,
        ),
        Column("Sensors", list(map(sensors, judgements)), is_text=True),
        *(
            Column(
                f"{title}{unit.bracket}",
                [unit.found(each.smallest.get(name)) for each in judgements],
                strong=_places(each.scored.name in detection.pareto for each in judgements)
                if name == "q90_95"
                else (),
            )
            for name, title in (("q90_95", "q90/95"), ("q90", "q90"), ("q50", "q50"))
        ),
        *(
            Column("False alarms [%]", [rate_text(each, population) for each in judgements])
            for population in tested(detection, Kind.HEALTHY)[:1]
        ),
        *(
            Column("AUC", [f"{each.area.value:.2f}" if each and each.area else HOLE for each in own])
            for own in areas
        ),
        Column("Cost [ms]", [HOLE if cost is None else two_digits(1e3 * cost) for cost in costs]),
    )
    order = (
        "Scores that do not exceed their false-alarm rate come first, by q90/95. Scores that exceed it (!) or"
        " have too few records to tell (?) follow. A bold q90/95 (in plain text *) is Pareto-optimal: no"
        " other score detects a smaller leak with the same or fewer sensors."
    )
    table = Table(columns, "All scores", "scores", tuple(_ranking_notes(detection)))
    return Block("ranking", "Ranking", (order,), (table,), ("ranking",))


def _ranking_notes(detection: Detection) -> Iterator[str]:
    asked, unit = detection.rules, severity_unit(detection)
    rate, confidence = f"{100.0 * asked.false_alarm_rate:g} %", f"{100.0 * asked.confidence:g} %"
    yield (
        f"q90/95: upper bound with {confidence} confidence on the {unit.quantity} found with"
        f" {100.0 * asked.probability:g} % probability; q90 and q50: estimates without confidence."
        f" ≤: at most the smallest tested; >: not found up to the largest tested;"
        f" {FROM_LEVELS}: read from the tested leaks, because no curve fitted (rounded up)."
    )
    yield (
        f"False alarms: healthy test records, with {confidence} interval, at thresholds for {rate}."
        " ↑, ↓, ↕: alarm if it rises, falls, or either. !: the lower limit of its rate, on healthy test"
        " records or in a shift, is above what the threshold allows. Cost: CPU time per record."
    )
    for level in chosen_levels(detection, 1):
        yield f"AUC: area under the ROC curve at {unit.text(level.severity)}."
    if not math.isnan(unit.per_mean_flow):
        yield (
            "Flows are means in this motion; at 8 MPa the same leak is"
            f" {unit.per_mean_flow:.2g} times as much."
        )


def false_alarms_block(detection: Detection) -> Block | None:
    """Rates on the healthy test records, each shift and each confusion; None if nothing was tested."""
    shown = [each for each in foremost(detection, _MOST_ALARMS) if each.threshold is not None]
    rules, total = detection.rules, len(detection.judgements)
    interval = f"In parentheses the {100.0 * rules.confidence:g} % interval (Clopper and Pearson)."
    left_out = f" {len(shown)} of {counted(total, 'score')}; CSV and JSON have all."
    notes = (interval + (left_out if len(shown) < total else ""),)
    tables = [
        Table(
            (_names(shown), *(_alarms(shown, population) for population in populations)),
            title,
            key,
            notes,
        )
        for key, title, kinds in (
            ("shifts", "Fresh healthy records and shifts", (Kind.HEALTHY, Kind.SHIFT)),
            ("confusions", "Other faults", (Kind.CONFUSION,)),
        )
        if (populations := tested(detection, *kinds))
    ]
    sentence = (
        f"Thresholds are set for {100.0 * rules.false_alarm_rate:g} % on healthy fit records. Bold (in plain"
        f" text *): significantly more alarms than the threshold allows ({100.0 * rules.confidence:g} %"
        " confidence). A score without false alarms in a shift is of use only where it finds leaks as well."
    )
    figures = ("false_alarms", "densities")
    return Block("false-alarms", "False alarms", (sentence,), tuple(tables), figures) if tables else None


def _names(shown: Sequence[Judgement]) -> Column:
    return Column("Score", [each.scored.name for each in shown], is_text=True)


def _alarms(shown: Sequence[Judgement], population: Population) -> Column:
    is_strong = (population in each.exceeded for each in shown)
    texts = [rate_text(each, population) for each in shown]
    return Column(f"{population.name} [%]", texts, strong=_places(is_strong))


def _places(are_strong: Iterator[bool]) -> tuple[int, ...]:
    return tuple(place for place, is_strong in enumerate(are_strong) if is_strong)


def levels_block(detection: Detection) -> Block | None:
    """Detections at each level by the foremost scores; None if no fault was tested."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if not levels:
        return None
    unit, least = severity_unit(detection), detection.rules.probability
    shown = [each for each in foremost(detection, _MOST_LEVELS) if each.threshold is not None]
    columns = [_names(shown)]
    for level in levels:
        found = [(each, own.detected if (own := level_of(each, level)) else None) for each in shown]
        texts = [
            HOLE
            if rate is None or not rate.total
            else f"{rate.count} of {rate.total}"
            if level in each.counted
            else percent(rate.value)
            for each, rate in found
        ]
        is_strong = (bool(rate and rate.value >= least and level not in each.counted) for each, rate in found)
        columns.append(Column(f"{unit.value(level.severity):.3g}", texts, strong=_places(is_strong)))
    title = f"Detected [%] at each {unit.quantity}{unit.bracket}"
    note = f"Bold (in plain text *): {100.0 * least:g} % or more. All scores are in JSON and CSV."
    paragraph = (
        "Points are the tested levels, curves are fitted over the true severity of each record. "
        "Results come from the curve if it describes the points, otherwise only from the levels."
    )
    table = Table(tuple(columns), title, "levels", (note,))
    return Block("levels", "Probability of detection", (paragraph,), (table,), ("pod", "roc", "det"))
