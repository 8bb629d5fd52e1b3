"""Which sections make up a report."""

from __future__ import annotations

from dataclasses import replace

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Document
from hydrofdi.report.readings import ReadingsStudy
from hydrofdi.report.sections.controls import controls_block
from hydrofdi.report.sections.doubts import doubts_block
from hydrofdi.report.sections.external import external_block
from hydrofdi.report.sections.holes import holes_block, remarks_block
from hydrofdi.report.sections.provenance import provenance_block
from hydrofdi.report.sections.readings import readings_block
from hydrofdi.report.sections.readings_controls import readings_controls_block
from hydrofdi.report.sections.reference import reference_block
from hydrofdi.report.sections.replicates import replicates_block
from hydrofdi.report.sections.sensitivity import sensitivity_block, settled_block
from hydrofdi.report.sections.small_leakage import small_leakage_block
from hydrofdi.report.sections.standing import standing_block
from hydrofdi.report.sections.verdicts import guarded_block, verdicts_block

_LEAD = (
    "Change δ of the RMS of the wavelet details of the chamber-1 pressure with internal leakage and with the"
    " effective bulk modulus (EBM) of the fluid. After Maddahi et al., CDSR 2015, paper 181; all numbers are"
    " computed, none is printed in the paper."
)


def compose_report(analysis: Analysis) -> Document:
    """All sections of a report; an ensemble has its own."""
    if analysis.readings is not None:
        return Document(analysis.table.name, (_LEAD,), _ensemble_blocks(analysis, analysis.readings))
    blocks = (
        remarks_block(analysis),
        holes_block(analysis),
        doubts_block(analysis),
        external_block(analysis),
        sensitivity_block(analysis),
        settled_block(analysis),
        small_leakage_block(analysis),
        replicates_block(analysis),
        standing_block(analysis) if analysis.has_baseline else None,
        verdicts_block(analysis),
        controls_block(analysis) if analysis.has_baseline else None,
        reference_block(analysis),
        _signals_block(),
        provenance_block(analysis),
    )
    return Document(analysis.table.name, (_LEAD,), tuple(map(_without_empty_sheets, filter(None, blocks))))


def _ensemble_blocks(analysis: Analysis, study: ReadingsStudy) -> tuple[Block, ...]:
    guarded = guarded_block(analysis)
    blocks = (
        remarks_block(analysis),
        guarded,
        doubts_block(analysis),
        readings_block(study),
        readings_controls_block(study),
        provenance_block(analysis),
    )
    return tuple(block for block in blocks if block is not None)


def _without_empty_sheets(block: Block) -> Block:
    return replace(block, sheets=tuple(sheet for sheet in block.sheets if len(sheet.rows)))


def _signals_block() -> Block:
    return Block("signals", "Signals and details", figures=("figure2", "figure3", "figure4"))
