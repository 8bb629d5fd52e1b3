"""Table 2: RMS and δ of all levels over the EBM, with the smallest leakage and with none."""

from __future__ import annotations

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.table import SensitivityTable, TableRow
from hydrofdi.report.wording import HOLE, kilopascal, leakage_label, megapascal, signed


def small_leakage_block(analysis: Analysis) -> Block | None:
    """Table 2 and its sealed control; None where the experiment varies more than leakage and EBM."""
    table = analysis.table
    if table.label_names:
        return None
    requests = sorted({row.leakage_request for row in table.rows})[:2]
    sheets = tuple(_sheet(table, [row for row in table.rows if row.leakage_request == q]) for q in requests)
    legend = (
        "RMS of the detail coefficients of the chamber-1 pressure; δ against the fixed normal,"
        " δ′ against the matched baseline."
    )
    return Block("table2", "Table 2: the small leakage over the EBM", (legend,), sheets[::-1])


def _sheet(table: SensitivityTable, rows: list[TableRow]) -> Sheet:
    rows = sorted(rows, key=lambda row: row.bulk_modulus)
    leakage = "sealed" if rows[0].is_sealed else f"{leakage_label(rows[0])} L/min"
    headers = ["Level", "Normal RMS [kPa]"]
    for row in rows:
        beta = megapascal(row.bulk_modulus)
        headers += [f"{beta} MPa: RMS [kPa]", "δ [%]", "δ′ [%]"]
    normal = _normal_row(table)
    return Sheet(
        key="table2-sealed" if rows[0].is_sealed else "table2-leaky",
        title="Control: no leakage" if rows[0].is_sealed else f"Small leakage: {leakage}",
        headers=tuple(headers),
        rows=tuple(_level_cells(level, normal, rows) for level in range(table.n_level)),
    )


def _normal_row(table: SensitivityTable) -> TableRow | None:
    beta = table.normal_bulk_modulus
    return next((row for row in table.rows if row.is_sealed and row.bulk_modulus == beta), None)


def _level_cells(level: int, normal: TableRow | None, rows: list[TableRow]) -> tuple[Cell, ...]:
    healthy = Cell(HOLE) if normal is None else _rms_cell(normal, level)
    cells = [Cell(f"d{level + 1}"), healthy]
    for row in rows:
        fixed, matched = row.delta_fixed[level], row.delta_matched[level]
        cells += [
            _rms_cell(row, level),
            Cell(signed(fixed), value=fixed),
            Cell(signed(matched), value=matched),
        ]
    return tuple(cells)


def _rms_cell(row: TableRow, level: int) -> Cell:
    return Cell(kilopascal(row.detail_rms[level]), value=row.detail_rms[level])
