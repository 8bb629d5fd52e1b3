"""Alarms of machines whose seal is sound: fresh healthy ones, shifted ones, those with another fault."""

from __future__ import annotations

from hydrofdi.evaluation.populations import Kind, Population
from hydrofdi.report.detection.selection import foremost, tested
from hydrofdi.report.detection.wording import rate_cell
from hydrofdi.report.document import Block, Cell, Rows, Sheet
from hydrofdi.settings.counting import counted
from hydrofdi.studies.judgement import Detection, Judgement

_MOST = 20


def false_alarms_block(detection: Detection) -> Block | None:
    """Rates on the healthy test records, each shift and each confusion; None if nothing was tested."""
    if not tested(detection, Kind.HEALTHY, Kind.SHIFT, Kind.CONFUSION):
        return None
    groups = {
        "shifts": ("Fresh healthy records and shifts", (Kind.HEALTHY, Kind.SHIFT)),
        "confusions": ("Other faults", (Kind.CONFUSION,)),
    }
    sheets = [_sheet(detection, key, title, kinds) for key, (title, kinds) in groups.items()]
    sentence = (
        f"Thresholds are set for {100.0 * detection.rules.false_alarm_rate:g} % on healthy fit records."
        " Bold (in plain text !): significantly more alarms than the threshold allows"
        f" ({100.0 * detection.rules.confidence:g} % confidence)."
        " A score without false alarms in a shift is of use only where it finds leaks as well."
    )
    kept = tuple(sheet for sheet in sheets if len(sheet.headers) > 1)
    return Block("false-alarms", "False alarms", (sentence,), kept, ("false_alarms", "densities"))


def _sheet(detection: Detection, key: str, title: str, kinds: tuple[Kind, ...]) -> Sheet:
    populations = tested(detection, *kinds)
    shown = [each for each in foremost(detection, _MOST) if each.threshold is not None]

    def row(judgement: Judgement) -> tuple[Cell, ...]:
        return Cell(judgement.scored.name), *(_cell(judgement, population) for population in populations)

    headers = ("Score", *(f"{population.name} [%]" for population in populations))
    return Sheet(key, title, headers, Rows(shown, row), text_columns=(0,), note=_note(detection, len(shown)))


def _cell(judgement: Judgement, population: Population) -> Cell:
    return rate_cell(judgement, population, is_strong=population in judgement.exceeded)


def _note(detection: Detection, n_shown: int) -> str:
    interval = f"In parentheses the {100.0 * detection.rules.confidence:g} % interval (Clopper and Pearson)."
    total = len(detection.judgements)
    return (
        interval
        if n_shown == total
        else f"{interval} {n_shown} of {counted(total, 'score')}; CSV and JSON have all."
    )
