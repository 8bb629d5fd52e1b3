"""The report of the paper's study: its sections, its data for programs, and its figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from hydrofdi.papers.maddahi2015.conclusions import (
    claim_record,
    claims_block,
    guarded_block,
    standing_blocks,
)
from hydrofdi.papers.maddahi2015.controls import controls_block, controls_record
from hydrofdi.papers.maddahi2015.scenario_tables import scenario_blocks
from hydrofdi.papers.maddahi2015.scenarios import scenarios_record
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.papers.maddahi2015.tables import deviations, reference_block, table2_block, table3_blocks
from hydrofdi.report.changes import doubts_block, holes_block, remarks_block, settled_block
from hydrofdi.report.composition import Report, answers
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.provenance import provenance_block
from hydrofdi.report.record import general_record
from hydrofdi.report.table import Block, plain

if TYPE_CHECKING:
    from hydrofdi.report.table import FigureKind

_LEAD = (
    "Change δ of the RMS of the wavelet details of the chamber-1 pressure with internal leakage and with the"
    " effective bulk modulus (EBM) of the fluid. After Maddahi et al., CDSR 2015, paper 181; all "
    "numbers are computed; none comes from the paper."
)


@dataclass(frozen=True)
class StudyReport(Report):
    """The general report with the paper's tables, claims, controls and figures."""

    analysis: Study

    @property
    def usual_figure(self) -> str:
        """The scenarios where the experiment has any, else δ."""
        return "sensitivity" if self.analysis.scenarios is None else "scenarios"

    @property
    def lead(self) -> str:
        """What the report is about."""
        return _LEAD

    def blocks(self) -> Iterator[Block | None]:
        """The sections of the report."""
        study = self.analysis
        yield remarks_block(study.data)
        if study.scenarios is not None:
            yield from answers(guarded_block(study))
            yield doubts_block(study)
            answer, controls = scenario_blocks(study.scenarios)
            yield from answers(answer)
            yield controls
            yield indicators_block(study.indicators, study.table)
            yield provenance_block(study.data)
            return
        yield holes_block(study)
        yield doubts_block(study)
        yield from (replace(block, is_answer=False) for block, _ in self.views)
        yield from table3_blocks(study)
        yield settled_block(study)
        yield table2_block(study)
        standing, phases = standing_blocks(study) if study.has_baseline else (None, None)
        yield claims_block(study)
        yield from answers(standing)
        yield phases
        yield controls_block(study.sealed, study.leaky) if study.has_baseline else None
        yield reference_block(study)
        yield indicators_block(study.indicators, study.table)
        yield Block("signals", "Signals and details", figures=("figure2", "figure3", "figure4"))
        yield provenance_block(study.data)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that do not exist are None.

        The thousands of runs, checks and controls of an ensemble are left to the tidy forms; what they come
        to in each scenario stands under ``scenarios``.
        """
        study = self.analysis
        is_single = study.scenarios is None
        record = general_record(study, with_rows=is_single)
        for _, data in self.views:
            record |= data
        record |= {
            "claims": [claim_record(study, each) for each in study.claims],
            "guarded_claims": list(study.data.experiment.claims),
            "controls": controls_record(study.sealed, study.leaky, study.standings)
            if is_single
            else {"sealed_alarms": [], "best_level_matched": []},
            "reference": deviations(study.table, study.data.experiment.reference) if is_single else [],
        }
        if study.scenarios is not None:
            record["scenarios"] = scenarios_record(study.scenarios)
        if study.grid.lack:
            record["claims_not_evaluated"] = study.grid.lack
        finished: dict[str, Any] = plain(record)
        return finished

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        from hydrofdi.papers.maddahi2015.figures.signals import study_figures

        own = study_figures(self.analysis) if self.analysis.has_results else {}
        return {**super().figures(), **own}

    def checks(self) -> dict[str, bool | None]:
        """The claims that the experiment file lists, and whether they hold."""
        word = {True: "holds", False: "does not hold", None: "is not decided"}
        return {
            f"{result.claim.id} {word[result.reproduced]}: {result.claim.sentence}"
            f" (margin {result.margin:.2f} points)": result.reproduced
            for result in self.analysis.guarded
        }
