"""All scores side by side, the best first."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.selection import chosen_levels, level_of, tested
from hydrofdi.report.detection.wording import (
    FROM_LEVELS,
    cost_cell,
    found_cell,
    rate_cell,
    sensors,
    severity_unit,
)
from hydrofdi.report.document import Block, Cell, Rows, Sheet
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.judgement import Detection, Judgement

_KEEPING = {True: "", None: " ?", False: " !"}
_MARKS = {"rising": "↑", "falling": "↓", "both": "↕"}


def ranking_block(detection: Detection) -> Block:
    """Every score that was tried."""
    order = (
        "Scores that do not exceed their false-alarm rate come first, by q90/95. Scores that exceed it (!) or"
        " have too few records to tell (?) follow. A bold q90/95 (in plain text *) is Pareto-optimal: no"
        " other score detects a smaller leak with the same or fewer sensors."
    )
    return Block(
        "ranking",
        "Ranking",
        (order,),
        (ranking_sheet(detection, detection.judgements, "scores", "All scores"),),
    )


def ranking_sheet(detection: Detection, judgements: Sequence[Judgement], key: str, title: str) -> Sheet:
    """A row for each of some judgements.

    Parameters
    ----------
    detection : Detection
    judgements : sequence of Judgement
    key, title : str
    """
    unit, levels = severity_unit(detection), chosen_levels(detection, 1)
    healthy = tested(detection, Kind.HEALTHY)
    shown = f" [{unit.name}]" if unit.name else ""
    headers = (
        "Score", "Sensors", f"q90/95{shown}", f"q90{shown}", f"q50{shown}",
        *("False alarms [%]" for _ in healthy[:1]),
        *("AUC" for _ in levels), "Cost [ms]",
    )  # fmt: skip

    def row(judgement: Judgement) -> tuple[Cell, ...]:
        return _row(detection, judgement, healthy[:1], levels)

    return Sheet(key, title, headers, Rows(judgements, row), text_columns=(0, 1))


def _row(
    detection: Detection,
    judgement: Judgement,
    healthy: Sequence[Population],
    levels: Sequence[Population],
) -> tuple[Cell, ...]:
    unit, found = severity_unit(detection), judgement.smallest
    best = found_cell(found.get("q90_95"), unit)
    name = f"{judgement.scored.name} {_MARKS[judgement.direction]}{_KEEPING[judgement.keeps_its_rate]}"
    return (
        Cell(name),
        Cell(sensors(judgement)),
        Cell(best.text, judgement.scored.name in detection.pareto, best.value),
        found_cell(found.get("q90"), unit),
        found_cell(found.get("q50"), unit),
        *(rate_cell(judgement, population) for population in healthy),
        *(_area_cell(judgement, level) for level in levels),
        cost_cell(judgement),
    )


def _area_cell(judgement: Judgement, population: Population) -> Cell:
    level = level_of(judgement, population)
    if level is None or level.area is None:
        return Cell(HOLE)
    return Cell(f"{level.area.value:.2f}", value=level.area.value)


def ranking_note(detection: Detection) -> str:
    """How the columns are read."""
    asked, unit = detection.rules, severity_unit(detection)
    middle = chosen_levels(detection, 1)
    area = f" AUC: area under the ROC curve at {unit.text(middle[0].severity)}." if middle else ""
    rate, confidence = f"{100.0 * asked.false_alarm_rate:g} %", f"{100.0 * asked.confidence:g} %"
    flow = (
        f" Flows are means in this motion; at 8 MPa the same leak is {unit.per_mean_flow:.2g} times as much."
    )
    flow = "" if math.isnan(unit.per_mean_flow) else flow
    return (
        f"q90/95: upper bound with {confidence} confidence on the {unit.quantity} found with"
        f" {100.0 * asked.probability:g} % probability; q90 and q50: estimates without confidence."
        f" In all three columns, ≤: at most the smallest tested; >: not found up to the largest tested;"
        f" {FROM_LEVELS}: from the tested levels, without a fitted curve: a level counts as the largest true"
        " severity of its records, which may be above the nominal one; estimates are interpolated."
        f" False alarms: healthy test records, with {confidence} interval, at thresholds for {rate}."
        " ↑, ↓, ↕: alarm if it rises, falls, or either. !: exceeds its false-alarm rate, because the"
        " lower limit of its rate, on healthy test records or in a shift, is above what the threshold allows;"
        f" ?: too few records to tell.{area} Cost: CPU time per record.{flow}"
    )
