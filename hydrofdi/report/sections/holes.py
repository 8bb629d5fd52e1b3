"""Runs without results, and remarks on all runs."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.quality.failures import remedy
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Rows, Sheet
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.report.sections.quantiles import MANY_ROWS
from hydrofdi.report.wording import lead_cells, lead_headers
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.results import MISSING


def remarks_block(data: ExperimentData) -> Block | None:
    """Remarks on all runs: another version of the physics, or another request."""
    sentences = [*data.remarks]
    if data.physics_version != PHYSICS_VERSION:
        sentences.append(
            f"Computed with version {data.physics_version} of the physics; this hydrofdi has version"
            f" {PHYSICS_VERSION}, and runs that are computed now may differ."
        )
    return Block("remarks", "Remarks", tuple(sentences)) if sentences else None


def holes_block(analysis: Analysis) -> Block | None:
    """How many runs have no results, the remedy, and a list of them; None if all runs have results."""
    holes = [row for row in analysis.table.rows if row.status != "ok"]
    if not holes:
        return None
    verb = "has" if len(holes) == 1 else "have"
    lead = f"{len(holes):,} of {counted(len(analysis.table.rows), 'run')} {verb} no results."
    return Block("holes", "What is missing", (lead, *_kinds(holes)), (_sheet(analysis.table, holes),))


def _sheet(table: SensitivityTable, holes: list[TableRow]) -> Sheet:
    """The first runs without results."""
    what = lead_headers(table)[:-1]
    n_row = min(len(holes), MANY_ROWS)
    title = f"Runs without results: the first {n_row} of {len(holes):,}"
    return Sheet(
        "runs-without-results",
        title if n_row < len(holes) else "Runs without results",
        (*what, "Status", "Reason"),
        Rows(holes[:n_row], lambda row: (*lead_cells(table, row)[:-1], Cell(row.status), Cell(row.message))),
        text_columns=(len(what), len(what) + 1),
    )


def _kinds(holes: list[TableRow]) -> Iterator[str]:
    """How many runs have each status, and what to do about them."""
    for status in dict.fromkeys(row.status for row in holes):
        what = _remedy(status)
        count = counted(sum(row.status == status for row in holes), "run")
        yield f"{status}, {count}" + (f". Remedy: {what}." if what else ".")


def _remedy(status: str) -> str:
    if status == MISSING:
        return "'hydrofdi sweep CONFIG' computes the missing runs and keeps the others"
    return remedy(status)
