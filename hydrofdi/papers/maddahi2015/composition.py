"""Which sections make up the report of the paper's study."""

from __future__ import annotations

from dataclasses import replace

from hydrofdi.papers.maddahi2015.claims import D2, D3
from hydrofdi.papers.maddahi2015.scenarios.study import ScenarioStudy
from hydrofdi.papers.maddahi2015.sections.claims import checks_block, claims_block, guarded_block
from hydrofdi.papers.maddahi2015.sections.controls import controls_block
from hydrofdi.papers.maddahi2015.sections.reference import reference_block
from hydrofdi.papers.maddahi2015.sections.scenario_controls import scenario_controls_block
from hydrofdi.papers.maddahi2015.sections.scenarios import scenarios_block
from hydrofdi.papers.maddahi2015.sections.standing import phases_block, standing_block
from hydrofdi.papers.maddahi2015.sections.table2 import table2_block, table3_blocks
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.papers.maddahi2015.views import asked_views
from hydrofdi.report.composition import answers, compose_empty, document_of
from hydrofdi.report.document import Block, Document
from hydrofdi.report.indicators.section import indicator_blocks
from hydrofdi.report.sections.provenance import provenance_block
from hydrofdi.report.sections.runs import doubts_block, holes_block, remarks_block, settled_block

_LEAD = (
    "Change δ of the RMS of the wavelet details of the chamber-1 pressure with internal leakage and with the"
    " effective bulk modulus (EBM) of the fluid. After Maddahi et al., CDSR 2015, paper 181; all "
    "numbers are computed; none comes from the paper."
)


def compose_study(study: Study) -> Document:
    """All sections of the report; an ensemble has its own."""
    if not study.has_results:
        return compose_empty(study, _LEAD)
    blocks = _blocks(study) if study.scenarios is None else _ensemble_blocks(study, study.scenarios)
    return document_of(study.table.name, _LEAD, blocks)


def _blocks(study: Study) -> tuple[Block | None, ...]:
    return (
        remarks_block(study.data),
        holes_block(study),
        doubts_block(study),
        *(replace(block, is_answer=False) for block, _ in asked_views(study, (D2, D3))),
        *table3_blocks(study),
        settled_block(study),
        table2_block(study),
        claims_block(study),
        *answers(standing_block(study) if study.has_baseline else None),
        phases_block(study) if study.has_baseline else None,
        checks_block(study),
        controls_block(study) if study.has_baseline else None,
        reference_block(study),
        *indicator_blocks(study),
        Block("signals", "Signals and details", figures=("figure2", "figure3", "figure4")),
        provenance_block(study.data),
    )


def _ensemble_blocks(study: Study, scenarios: ScenarioStudy) -> tuple[Block | None, ...]:
    return (
        remarks_block(study.data),
        *answers(guarded_block(study)),
        doubts_block(study),
        *answers(scenarios_block(scenarios)),
        scenario_controls_block(scenarios),
        *indicator_blocks(study),
        provenance_block(study.data),
    )
