"""The report of the paper's study: what it says, computed once; its sections, data and figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.config.experiment import ReferenceCell, ReferenceConfig
from hydrofdi.papers.maddahi2015 import conclusions
from hydrofdi.papers.maddahi2015.conclusions import controls_record
from hydrofdi.papers.maddahi2015.data import StudyData
from hydrofdi.papers.maddahi2015.scenarios import (
    scenario_blocks,
    scenarios_record,
)
from hydrofdi.report import changes
from hydrofdi.report.composition import Report, answers
from hydrofdi.report.indicators import indicators_block
from hydrofdi.report.provenance import provenance_block
from hydrofdi.report.record import general_record
from hydrofdi.report.runs import RunTable
from hydrofdi.report.table import Block, FigureKind, Table, plain
from hydrofdi.settings.messages import counted
from hydrofdi.store.layout import names
from hydrofdi.units import convert


@dataclass(frozen=True)
class StudyReport(StudyData, Report):
    """The general report with the paper's tables, claims, controls and figures."""

    lead = (
        "Change δ of the RMS of the wavelet details of the chamber-1 pressure with internal leakage and with"
        " the EBM of the fluid. After Maddahi et al., CDSR 2015, paper 181; no number comes from the paper."
    )

    @property
    def usual_figure(self) -> str:
        """The scenarios where the experiment has any, else δ."""
        return "sensitivity" if self.scenarios is None else "scenarios"

    def blocks(self) -> Iterator[Block | None]:
        """The sections of the report."""
        yield changes.remarks_block(self.data)
        if self.scenarios is not None:
            yield from answers(
                Block("guarded", "Required claims, in all feasible scenarios", conclusions.required(self))
            )
            yield from changes.doubts_blocks(self.data)
            answer, controls = scenario_blocks(self.scenarios)
            yield from answers(answer)
            yield controls
            yield indicators_block(self.indicators)
            yield provenance_block(self.data)
            return
        yield changes.holes_block(self.data)
        yield from changes.doubts_blocks(self.data)
        yield from (replace(block, is_answer=False) for block, _ in self.views)
        yield from table3_blocks(self)
        yield changes.settled_block(self)
        yield table2_block(self)
        standing, phases = conclusions.standing_blocks(self) if self.has_baseline else (None, None)
        yield conclusions.claims_block(self)
        yield from answers(standing)
        yield phases
        yield reference_block(self)
        yield indicators_block(self.indicators)
        figures = ("figure2", "figure3", "figure4", "spectrum", "mode_plane")
        yield Block("signals", "Signals and details", figures=figures)
        yield provenance_block(self.data)

    def record(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that do not exist are None.

        The thousands of runs, checks and controls of an ensemble are left to the tidy forms; what they come
        to in each scenario stands under ``scenarios``.
        """
        is_single = self.scenarios is None
        record = general_record(self, with_rows=is_single)
        for _, data in self.views:
            record |= data
        record |= {
            "claims": [conclusions.claim_record(self, each) for each in self.claims],
            "guarded_claims": list(self.data.experiment.claims),
            "controls": controls_record(self.sealed, self.leaky, self.standings)
            if is_single
            else {"sealed_alarms": [], "best_level_matched": []},
            "reference": deviations(self.table, self.data.experiment.reference) if is_single else [],
        }
        if self.scenarios is not None:
            record["scenarios"] = scenarios_record(self.scenarios)
        if self.grid.lack:
            record["claims_not_evaluated"] = self.grid.lack
        finished: dict[str, Any] = plain(record)
        return finished

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""
        from hydrofdi.papers.maddahi2015.figures.signals import study_figures

        own = study_figures(self) if self.has_results else {}
        return {**super().figures(), **own}

    def checks(self) -> dict[str, bool | None]:
        """The claims that the experiment file lists, and whether they hold."""
        word = {True: "holds", False: "does not hold", None: "is not decided"}
        return {
            f"{result.claim.id} {word[result.reproduced]}: {result.claim.sentence}"
            f" (margin {result.margin:.2f} points)": result.reproduced
            for result in self.guarded
        }


NONE_GIVEN = (
    "No published value is compared: the digits of the paper's Tables 2 and 3 are lost in the only text that"
    " hydrofdi was made from. If you have the printed paper, you can enter its numbers under reference: "
    "in the experiment file."
)


def table3_blocks(study: StudyData) -> tuple[Block, Block]:
    """The table of all runs; the one against the fixed baseline is the answer."""
    block = changes.changes_block(study, "Table 3: change of the details with leakage and EBM", "table3")
    reason = study.no_changes
    legend, *bands = (reason, *block.paragraphs) if reason else block.paragraphs
    first, *others = block.tables
    figures = ("sensitivity",) if study.plane else ()
    answer = replace(block, paragraphs=(legend,), tables=(first,), figures=figures, is_answer=True)
    rest = "Table 3 with the matched baseline"
    return answer, Block("table3-matched", rest, tuple(bands), tuple(others))


def table2_block(study: StudyData) -> Block | None:
    """Table 2 and its sealed control; None if more than leakage and EBM varies, or they form no grid."""
    table = study.table
    if table.label_names or study.grid.lack:
        return None
    requests = np.unique(table.leakage_requests)[:2]
    rows = table.of(np.isin(table.leakage_requests, requests))
    return Block(
        "table2",
        "Table 2: RMS over the EBM, sealed and with the small leakage",
        (),
        (changes.rms_table(rows),),
    )


def deviations(table: RunTable, reference: ReferenceConfig) -> list[dict[str, Any]]:
    """Every published value beside the computed one."""
    return [_deviation(table, cell, reference.tolerance) for cell in reference.cells]


def _deviation(table: RunTable, cell: ReferenceCell, general: float) -> dict[str, Any]:
    level, is_delta, computed = int(cell.level[1:]) - 1, cell.delta is not None, math.nan
    rows = np.stack([table.leakage_flows, table[names.BULK_MODULUS]], axis=1)
    is_it = np.isclose(rows, (cell.leakage, cell.bulk_modulus), rtol=1e-6, atol=0.0).all(axis=1)
    if is_it.any() and level < table.n_level:
        levels = table.changes("fixed") if is_delta else table[names.DETAIL_RMS]
        computed = float(levels[is_it.argmax(), level])
    published = cell.delta if cell.delta is not None else cell.rms
    assert published is not None
    deviation = computed - published if is_delta else 100.0 * (computed - published) / published
    tolerance = general if cell.tolerance is None else cell.tolerance
    return {
        "leakage_L_per_min": convert(cell.leakage, "L/min"),
        "bulk_modulus_MPa": convert(cell.bulk_modulus, "MPa"),
        "level": cell.level,
        "quantity": "delta_fixed_percent" if is_delta else "detail_rms_Pa",
        "published": published,
        "computed": computed,
        "deviation": deviation,
        "tolerance": tolerance,
        "agrees": None if math.isnan(deviation) else abs(deviation) <= tolerance,
    }


def reference_block(study: StudyData) -> Block:
    """Published values beside the computed ones, or the sentence that there are none."""
    reference, title = study.data.experiment.reference, "Published values"
    found = deviations(study.table, reference)
    if not found:
        return Block("reference", title, (NONE_GIVEN,))
    agrees = [each["agrees"] for each in found]
    n_compared = counted(len(agrees) - agrees.count(None), "published value")
    source = f"; source: {reference.source}" if reference.source else ""
    said = f"Within the tolerance: {agrees.count(True)} of {n_compared}{source}."
    note = "Deviation and tolerance: percentage points of δ; percent of a published RMS. –: no such run."
    table = Table.of_records(found, title="Computed and published", key="reference", notes=(note,))
    return Block("reference", title, (said,), (table,))
