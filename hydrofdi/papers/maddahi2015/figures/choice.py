"""The runs that the paper's figures show, out of an experiment."""

from __future__ import annotations

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.grid.modes import ABSENT
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.store.layout import names


def run_position(study: Study, leakage: int, bulk_modulus: int) -> int:
    """Row of a run of the first scenario; `leakage` 0 is the sealed actuator, 1 the smallest leakage.

    Raises
    ------
    ReportError
        The experiment has no such run, or it did not succeed.
    """
    grid = study.grid
    position = int(grid.positions[0, leakage, bulk_modulus]) if leakage < grid.positions.shape[1] else ABSENT
    if position == ABSENT:
        raise ReportError("the experiment has no run of this leakage and EBM")
    status = study.data.columns[names.STATUS][position]
    if status != "ok":
        raise ReportError(f"a run of the figure has no results: {status}")
    return position


def shown_leakage(study: Study) -> int:
    """The smallest leakage, or the sealed actuator if there is no leakage."""
    return 1 if study.grid.leakage_flows else 0


def shown_bulk_moduli(study: Study) -> list[int]:
    """Positions of the EBM with a run of the shown leakage."""
    grid = study.grid
    return [b for b in range(len(grid.bulk_moduli)) if grid.positions[0, shown_leakage(study), b] != ABSENT]
