"""Table 3: δ of all modes and of the sealed controls against both baselines."""

from __future__ import annotations

from collections.abc import Callable

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Sheet, group_breaks
from hydrofdi.report.table import Levels, SensitivityTable, TableRow
from hydrofdi.report.wording import band_sentence, delta_cells, lead_cells, lead_headers, megapascal

BASELINES: dict[str, Callable[[TableRow], Levels]] = {
    "fixed": lambda row: row.delta_fixed,
    "matched": lambda row: row.delta_matched,
}
"""Kind of baseline → δ of a row against it."""


def baseline_title(table: SensitivityTable, baseline: str) -> str:
    """What δ is taken against, as a title."""
    if baseline == "fixed":
        others = ", else the row's own parameters" if table.label_names else ""
        normal = f"sealed, EBM {megapascal(table.normal_bulk_modulus)} MPa{others}"
        return f"δ [%] against the fixed normal ({normal})"
    return "δ [%] against the matched baseline (sealed, the row's own EBM)"


def sensitivity_block(analysis: Analysis) -> Block:
    """Table 3, once per baseline."""
    table = analysis.table
    legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell. Rows marked sealed are controls."
    return Block(
        "table3",
        "Table 3: change of the details with leakage and EBM",
        (legend, band_sentence(table)),
        tuple(_sheet(table, baseline) for baseline in BASELINES),
        ("sensitivity",),
    )


def _sheet(table: SensitivityTable, baseline: str) -> Sheet:
    delta = BASELINES[baseline]
    levels = [f"δd{level}" for level in range(1, table.n_level + 1)]
    return Sheet(
        key=f"table3-{baseline}",
        title=baseline_title(table, baseline),
        headers=(*lead_headers(table), *levels),
        rows=tuple((*lead_cells(row), *delta_cells(delta(row))) for row in table.rows),
        breaks=group_breaks([row.leakage_request for row in table.rows]),
    )
