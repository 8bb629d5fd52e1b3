"""Table 2: RMS and δ of all levels over the EBM, with the smallest leakage and with none."""

from __future__ import annotations

from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.report.wording import (
    HOLE,
    kilopascal,
    leakage_label,
    modulus_cell,
    modulus_header,
    modulus_text,
    signed,
)

_MOST_SIDE_BY_SIDE = 3
"""Most EBM for which the table has the paper's arrangement."""


def table2_block(study: Study) -> Block | None:
    """Table 2 and its sealed control; None if more than leakage and EBM varies, or they form no grid."""
    table = study.table
    if table.label_names or study.grid.lack:
        return None
    requests = sorted({row.leakage_request for row in table.rows})[:2]
    sheets = tuple(_sheet(table, [row for row in table.rows if row.leakage_request == q]) for q in requests)
    legend = (
        "RMS of the detail coefficients of the chamber-1 pressure; δ against the fixed baseline,"
        " δ′ against the matched baseline."
    )
    return Block("table2", "Table 2: the small leakage over the EBM", (legend,), sheets[::-1])


def _sheet(table: SensitivityTable, rows: list[TableRow]) -> Sheet:
    rows = sorted(rows, key=lambda row: row.bulk_modulus)
    is_sealed = rows[0].is_sealed
    key = "table2-sealed" if is_sealed else "table2-leaky"
    title = "Control: no leakage" if is_sealed else f"Small leakage: {leakage_label(rows[0])} L/min"
    if len(rows) <= _MOST_SIDE_BY_SIDE:
        return _wide_sheet(table, rows, key, title)
    return _long_sheet(rows, key, title)


def _wide_sheet(table: SensitivityTable, rows: list[TableRow], key: str, title: str) -> Sheet:
    """The paper's arrangement: one line per level, the EBM side by side."""
    headers = ["Level", "Normal RMS [kPa]"]
    for row in rows:
        headers += [f"{modulus_text(row.bulk_modulus)}: RMS [kPa]", "δ [%]", "δ′ [%]"]
    normal = _normal_row(table)
    lines = []
    for level in range(table.n_level):
        healthy = Cell(HOLE) if normal is None else _rms_cell(normal, level)
        cells = [cell for row in rows for cell in _mode_cells(row, level)]
        lines.append((Cell(f"d{level + 1}"), healthy, *cells))
    return Sheet(key, title, tuple(headers), tuple(lines))


def _long_sheet(rows: list[TableRow], key: str, title: str) -> Sheet:
    """One line per level and EBM."""
    pairs = [(level, row) for level in range(len(rows[0].detail_rms)) for row in rows]
    lines = [
        (Cell(f"d{level + 1}"), modulus_cell(row.bulk_modulus), *_mode_cells(row, level))
        for level, row in pairs
    ]
    breaks = group_breaks([level for level, _ in pairs])
    return Sheet(
        key, title, ("Level", modulus_header(), "RMS [kPa]", "δ [%]", "δ′ [%]"), tuple(lines), breaks
    )


def _mode_cells(row: TableRow, level: int) -> tuple[Cell, Cell, Cell]:
    fixed, matched = row.delta_fixed[level], row.delta_matched[level]
    return _rms_cell(row, level), Cell(signed(fixed), value=fixed), Cell(signed(matched), value=matched)


def _normal_row(table: SensitivityTable) -> TableRow | None:
    beta = table.normal_bulk_modulus
    return next((row for row in table.rows if row.is_sealed and row.bulk_modulus == beta), None)


def _rms_cell(row: TableRow, level: int) -> Cell:
    return Cell(kilopascal(row.detail_rms[level]), value=row.detail_rms[level])
