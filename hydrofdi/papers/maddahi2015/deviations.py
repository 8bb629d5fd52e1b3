"""Computed against published values."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hydrofdi.config.reference import ReferenceCell
from hydrofdi.report.runs import RunTable, TableRow
from hydrofdi.store import ExperimentData


@dataclass(frozen=True)
class Deviation:
    """One published value beside the computed one.

    Attributes
    ----------
    cell : ReferenceCell
    published, computed : float
        δ [%] or RMS [Pa]; the computed one is NaN if the experiment has no such run, or it failed.
    deviation : float
        Computed less published: percentage points of δ, percent of a published RMS.
    tolerance : float
        In the unit of the deviation.
    """

    cell: ReferenceCell
    published: float
    computed: float
    deviation: float
    tolerance: float

    @property
    def agrees(self) -> bool | None:
        """Whether the deviation is within the tolerance; None if nothing was computed."""
        return None if math.isnan(self.deviation) else abs(self.deviation) <= self.tolerance


def compare_reference(table: RunTable, data: ExperimentData) -> tuple[Deviation, ...]:
    """Every published value of an experiment's ``reference`` section beside the computed one."""
    reference = data.experiment.reference
    return tuple(
        _deviation(cell, table, reference.tolerance if cell.tolerance is None else cell.tolerance)
        for cell in reference.cells
    )


def _deviation(cell: ReferenceCell, table: RunTable, tolerance: float) -> Deviation:
    level = int(cell.level[1:]) - 1
    row = next((row for row in table.rows if _is_meant(row, cell)), None)
    known = row is not None and level < table.n_level
    if cell.delta is not None:
        computed = row.details.fixed[level] if row is not None and known else math.nan
        return Deviation(cell, cell.delta, computed, computed - cell.delta, tolerance)
    assert cell.rms is not None
    computed = row.details.rms[level] if row is not None and known else math.nan
    return Deviation(cell, cell.rms, computed, 100.0 * (computed - cell.rms) / cell.rms, tolerance)


def _is_meant(row: TableRow, cell: ReferenceCell) -> bool:
    return math.isclose(row.leakage_flow, cell.leakage, rel_tol=1e-6) and math.isclose(
        row.bulk_modulus, cell.bulk_modulus, rel_tol=1e-6
    )
