"""The runs of an experiment that are looked at before it is run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.assessment.step_limits import Distinct
from hydrofdi.config import ExperimentConfig, RunParameters, RunSpec, expand_runs
from hydrofdi.config.parameters import SENSING
from hydrofdi.config.request import OBSERVATION
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.config.study.table import StudyTable
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.simulation.kernels.lanes import WIDTH

Jobs = list[Job]

MOST_RUNS = 60
"""Runs of an experiment that are looked at; the others are left out."""


@dataclass(frozen=True)
class Selection:
    """Runs to look at.

    Attributes
    ----------
    jobs : list of Job
        Distinct runs with their K_i and ideal sensors.
    labels : tuple of str
        Varied parameters, besides EBM, internal leakage, sensors and analysis.
    n_left_out : int
        Number of further distinct runs.
    distinct : callable
        Gives one run of the experiment for each combination of sections that occurs.
    """

    jobs: Jobs
    labels: tuple[str, ...]
    n_left_out: int
    distinct: Distinct


def select_runs(experiment: ExperimentConfig, most: int = MOST_RUNS) -> Selection:
    """The runs of an experiment that differ in more than sensors and analysis, up to a number.

    Where there are more, the first run of every EBM × leakage is chosen, then the first of every
    value of what varies besides; of a study, the first run of every population, then the second, and so on.
    In an ensemble, a leakage that cannot be reached is a run without K_i.

    Raises
    ------
    ConfigError
        A leakage flow cannot be reached.
    """
    table = expand_runs(experiment)
    labels = tuple(name for name in table.axes if _is_label(name))
    distinct = table.runs.first(*(name for name in RunParameters.model_fields if name not in SENSING))
    if table.study is None:
        ordered = _most_different(table.runs, labels, distinct)
    else:
        ordered = distinct[np.argsort(_places(table.study)[distinct], kind="stable")].tolist()
    chosen = sorted(ordered[:most])
    return Selection(
        _jobs(list(table.runs.at(chosen)), experiment),
        labels,
        len(distinct) - len(chosen),
        table.runs.distinct,
    )


def _most_different(runs: Runs, labels: tuple[str, ...], distinct: NDArray[np.intp]) -> list[int]:
    """Positions of the runs that differ in more than their sensors, in the order in which they are chosen."""
    modes = runs.first("fluid", "leakage").tolist()
    others: dict[Any, int] = {}
    for position in runs.first(*{name.partition(".")[0] for name in labels}).tolist():
        others.setdefault(tuple(runs[position].parameters.shown_value(name) for name in labels), position)
    return list(dict.fromkeys([*modes, *others.values(), *distinct.tolist()]))


def _places(study: StudyTable) -> NDArray[np.intp]:
    """The place of each run in its population."""
    places = np.empty(len(study.of_run), dtype=np.intp)
    for population in range(len(study.populations)):
        own = np.flatnonzero(study.of_run == population)
        places[own] = np.arange(len(own))
    return places


def _jobs(runs: Sequence[RunSpec], experiment: ExperimentConfig) -> Jobs:
    required: Literal["any", "none"] = "none" if experiment.has_scenarios else "any"
    coefficients = leakage_coefficients(runs, InProcessEngine(), {}, required=required)
    return [
        Job(str(position), run.request.with_ideal_sensors().parameters, coefficient, run.analysis)
        for position, (run, coefficient) in enumerate(zip(runs, coefficients, strict=True))
    ]


def _is_label(name: str) -> bool:
    section = name.partition(".")[0]
    usual = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")
    return name not in usual and section not in OBSERVATION


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
        grids.setdefault((job.parameters.record, job.analysis), []).append(job)
    return [group[first : first + WIDTH] for group in grids.values() for first in range(0, len(group), WIDTH)]
