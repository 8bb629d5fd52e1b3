"""Do the runs of an experiment cross leakage and EBM, so that they form a grid of modes?

The sentences of the paper compare modes that share a leakage or an EBM. Runs whose leakage or EBM is drawn
from a range share none.
"""

from __future__ import annotations

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names

_FEW_CELLS, _CELLS_PER_RUN = 10_000, 4
"""A grid has few cells in all, or few for each of its runs."""


def missing_baseline(data: ExperimentData) -> str:
    """That the runs of an experiment have no healthy run to be compared with; empty if they have one."""
    if (data.fixed_baseline != names.NO_BASELINE).any():
        return ""
    return "Without a healthy run to compare with, the claims are not evaluated."


def missing_grid(experiment: ExperimentConfig, shape: tuple[int, int, int], n_run: int) -> str:
    """Why an experiment has no grid of modes, as a sentence; empty if it has one.

    Parameters
    ----------
    experiment : ExperimentConfig
    shape : tuple of int
        Different scenarios, leakages and EBM of its runs.
    n_run : int
        Runs that the grid would hold.
    """
    drawn = {*_drawn(experiment.sweep), *_drawn(experiment.ensemble)}
    found = [name for name in ("fluid.bulk_modulus", *INTERNAL_LEAKAGE_FORMS) if name in drawn]
    if found:
        verb = "is" if len(found) == 1 else "are"
        return _sentence(f"{' and '.join(found)} {verb} drawn from a range")
    n_scenario, n_leakage, n_bulk_modulus = shape
    if n_scenario * n_leakage * n_bulk_modulus <= max(_FEW_CELLS, _CELLS_PER_RUN * n_run):
        return ""
    among = f" among {n_scenario:,} sets of other parameters" if n_scenario > 1 else ""
    return _sentence(
        f"{counted(n_run, 'run')} have {counted(n_leakage, 'leakage')} and {n_bulk_modulus:,} EBM{among}"
    )


def _sentence(reason: str) -> str:
    return f"Leakage and EBM do not form a grid of modes ({reason}), so the claims are not evaluated."


def _drawn(block: SweepConfig) -> list[str]:
    """Parameters of a block that are drawn from a range."""
    over = block.sample.over if block.sample else {}
    names = [name for name, distribution in over.items() if "choice" not in distribution]
    return names + [name for part in block.union for name in _drawn(part)]
