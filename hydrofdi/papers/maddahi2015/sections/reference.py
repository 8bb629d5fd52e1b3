"""Computed, published and deviation, where the experiment file holds published values."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015.deviations import Deviation
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.wording import kilopascal, mode_name, signed
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import HOLE

NONE_GIVEN = (
    "No published value is compared: the digits of the paper's Tables 2 and 3 are lost in the only text that"
    " hydrofdi was made from. If you have the printed paper, you can enter its numbers under reference: "
    "in the"
    " experiment file."
)


def reference_block(study: Study) -> Block:
    """Published values beside the computed ones, or the sentence that there are none."""
    deviations = study.deviations
    if not deviations:
        return Block("reference", "Published values", (NONE_GIVEN,))
    decided = [deviation for deviation in deviations if deviation.agrees is not None]
    agreeing = sum(deviation.agrees is True for deviation in decided)
    source = study.data.experiment.reference.source
    sentence = (
        f"Within the tolerance: {agreeing} of {counted(len(decided), 'published value')}"
        f"{f'; source: {source}' if source else ''}."
    )
    holes = len(deviations) - len(decided)
    absent = f"{counted(holes, 'value')} could not be compared: there is no such run, or it failed."
    return Block(
        "reference", "Published values", (sentence, absent) if holes else (sentence,), (_sheet(deviations),)
    )


def _sheet(deviations: tuple[Deviation, ...]) -> Sheet:
    return Sheet(
        "reference",
        "Computed and published",
        ("Mode", "Level", "Quantity", "Computed", "Published", "Deviation", "Tolerance", "Agrees"),
        tuple(_cells(deviation) for deviation in deviations),
        text_columns=(0, 1, 2, 7),
        note="Deviation and tolerance: percentage points of δ; percent of a published RMS.",
    )


def _cells(deviation: Deviation) -> tuple[Cell, ...]:
    cell = deviation.cell
    is_delta = cell.delta is not None
    show = signed if is_delta else kilopascal
    agrees = {True: "yes", False: "no", None: HOLE}[deviation.agrees]
    return (
        Cell(mode_name(cell.leakage, cell.bulk_modulus)),
        Cell(cell.level),
        Cell("δ [%]" if is_delta else "RMS [kPa]"),
        Cell(show(deviation.computed), value=deviation.computed),
        Cell(show(deviation.published), value=deviation.published),
        Cell(signed(deviation.deviation, 2), value=deviation.deviation),
        Cell(f"{deviation.tolerance:g}"),
        Cell(agrees, deviation.agrees is False),
    )
