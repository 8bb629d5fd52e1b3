"""Table 3: δ of all modes and of the sealed controls against both baselines."""

from __future__ import annotations

from collections.abc import Callable

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.sections.doubts import doubt_cells, doubt_columns, doubt_headers, doubt_note
from hydrofdi.report.table import EXTERNAL, Levels, SensitivityTable, TableRow
from hydrofdi.report.wording import (
    band_sentence,
    delta_cells,
    kilopascal,
    labels_text,
    lead_cells,
    lead_headers,
    megapascal,
)

BASELINES: dict[str, Callable[[TableRow], Levels]] = {
    "fixed": lambda row: row.delta_fixed,
    "matched": lambda row: row.delta_matched,
}
"""Kind of baseline → δ of a row against it."""


def baseline_title(table: SensitivityTable, baseline: str) -> str:
    """What δ is taken against, as a title."""
    held = {name: table.baseline[name] for name in table.label_names if name in table.baseline}
    outside = {name: held.pop(name) for name in list(held) if name.startswith(EXTERNAL)}
    sealed = "sealed inside and out" if outside and not any(outside.values()) else "sealed"
    if baseline == "matched":
        return f"δ [%] against the matched baseline ({sealed}, the row's own EBM)"
    state = [sealed, f"EBM {megapascal(table.normal_bulk_modulus)} MPa"]
    state += [labels_text(held)] if held else []
    state += ["else the row's own parameters"] if len(held) + len(outside) < len(table.label_names) else []
    return f"δ [%] against the fixed normal ({', '.join(state)})"


def sensitivity_block(analysis: Analysis) -> Block:
    """Table 3, once per baseline; the RMS alone where no run is healthy."""
    table = analysis.table
    if not analysis.has_baseline:
        return Block("table3", "RMS of the details", (band_sentence(table),), (_rms_sheet(table),))
    sealed = "have no internal leakage" if table.varies_external else "are controls"
    legend = f"Marked: largest positive δ of the row. δ > 0: the RMS fell. Rows marked sealed {sealed}."
    return Block(
        "table3",
        "Table 3: change of the details with leakage and EBM",
        (legend, band_sentence(table)),
        tuple(_sheet(table, baseline) for baseline in BASELINES),
        ("sensitivity",),
    )


def _rms_sheet(table: SensitivityTable) -> Sheet:
    levels = [f"d{level} [kPa]" for level in range(1, table.n_level + 1)]
    return Sheet(
        key="rms",
        title="RMS of the details of the chamber-1 pressure",
        headers=(*lead_headers(table), *levels, *doubt_headers(table)),
        rows=tuple(
            (
                *lead_cells(row),
                *(Cell(kilopascal(rms), value=rms) for rms in row.detail_rms),
                *doubt_cells(table, row),
            )
            for row in table.rows
        ),
        text_columns=doubt_columns(table, len(lead_headers(table)) + table.n_level),
        note=doubt_note(table),
    )


def _sheet(table: SensitivityTable, baseline: str) -> Sheet:
    delta = BASELINES[baseline]
    levels = [f"δd{level}" for level in range(1, table.n_level + 1)]
    return Sheet(
        key=f"table3-{baseline}",
        title=baseline_title(table, baseline),
        headers=(*lead_headers(table), *levels, *doubt_headers(table)),
        rows=tuple(
            (*lead_cells(row), *delta_cells(delta(row)), *doubt_cells(table, row)) for row in table.rows
        ),
        breaks=group_breaks([row.leakage_request for row in table.rows]),
        text_columns=doubt_columns(table, len(lead_headers(table)) + table.n_level),
        note=doubt_note(table),
    )
