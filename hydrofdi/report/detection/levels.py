"""How often each tested severity is found."""

from __future__ import annotations

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.selection import foremost, level_of
from hydrofdi.report.detection.wording import percent, severity_unit
from hydrofdi.report.document import Block, Cell, Rows, Sheet
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.judgement import Detection, Judgement

_MOST = 12


def levels_block(detection: Detection) -> Block | None:
    """Detections at each level by the foremost scores; None if no fault was tested."""
    levels = detection.records.chosen(Kind.FAULT, is_fit=False)
    if not levels:
        return None
    unit, asked = severity_unit(detection), detection.rules
    shown = [each for each in foremost(detection, _MOST) if each.threshold is not None]

    def row(judgement: Judgement) -> tuple[Cell, ...]:
        return Cell(judgement.scored.name), *(_cell(judgement, level, asked.probability) for level in levels)

    headers = ("Score", *(f"{unit.value(level.severity):.3g}" for level in levels))
    title = f"Detected [%] at each {unit.quantity}" + (f" [{unit.name}]" if unit.name else "")
    note = f"Bold (in plain text *): {100.0 * asked.probability:g} % or more. All scores are in JSON and CSV."
    sheet = Sheet("levels", title, headers, Rows(shown, row), text_columns=(0,), note=note)
    paragraph = (
        "Points are the tested levels, curves are fitted over the true severity of each record. "
        "Results come from the curve if it describes the points, otherwise only from the levels."
    )
    return Block("levels", "Probability of detection", (paragraph,), (sheet,), ("pod", "roc", "det"))


def _cell(judgement: Judgement, population: Population, probability: float) -> Cell:
    level = level_of(judgement, population)
    rate = None if level is None else level.detected
    if rate is None or not rate.total:
        return Cell(HOLE)
    if population in judgement.counted:
        return Cell(f"{rate.count} of {rate.total}", value=100.0 * rate.value)
    return Cell(percent(rate.value), rate.value >= probability, 100.0 * rate.value)
