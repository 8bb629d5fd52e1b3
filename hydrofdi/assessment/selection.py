"""The runs of an experiment that are looked at: one for each EBM and leakage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import ExperimentConfig, RunParameters, RunSpec, expand_runs
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.simulation.lanes import WIDTH

Jobs = list[Job]


def select_jobs(experiment: ExperimentConfig) -> Jobs:
    """The first run of every EBM × leakage of an experiment, with its K_i and ideal sensors.

    Raises
    ------
    ConfigError
        A leakage flow cannot be reached.
    """
    chosen: dict[Any, RunSpec] = {}
    for run in expand_runs(experiment).runs:
        chosen.setdefault((run.parameters.fluid, run.parameters.leakage), run)
    runs = list(chosen.values())
    coefficients = leakage_coefficients(runs, InProcessEngine(), {})
    return [
        Job(str(position), run.parameters.with_ideal_sensors(), coefficient)
        for position, (run, coefficient) in enumerate(zip(runs, coefficients, strict=True))
    ]


def computed_rows(jobs: Sequence[Job]) -> list[dict[str, NDArray[np.float64]]]:
    """All variables of each job, in their order."""
    rows: dict[str, dict[str, Any]] = {}
    for group in _groups(jobs):
        columns = compute_columns(group)
        for position, job in enumerate(group):
            rows[job.run_id] = {
                name: values[position] for name, values in columns.items() if len(values) == len(group)
            }
    return [rows[job.run_id] for job in jobs]


def _groups(jobs: Sequence[Job]) -> list[Jobs]:
    grids: dict[Any, Jobs] = {}
    for job in jobs:
        grids.setdefault(_grid(job.parameters), []).append(job)
    return [group[first : first + WIDTH] for group in grids.values() for first in range(0, len(group), WIDTH)]


def _grid(parameters: RunParameters) -> Any:
    return parameters.run, parameters.wavelet, parameters.n_discarded
