"""The runs of an experiment that are looked at before it is run, and what is computed of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.api.step_limits import Distinct
from hydrofdi.config import ExperimentConfig, RunParameters, expand_runs
from hydrofdi.config.request import OBSERVATION, SENSING
from hydrofdi.config.run_table.runs import Runs
from hydrofdi.config.study.table import StudyTable
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.simulation.kernels.lanes import WIDTH

MOST_RUNS, MOST_HALVINGS = 60, 6

_USUAL = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")


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

    jobs: list[Job]
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
    labels = tuple(
        name for name in table.axes if name not in _USUAL and name.partition(".")[0] not in OBSERVATION
    )
    distinct = table.runs.first(*(name for name in RunParameters.model_fields if name not in SENSING))
    if table.study is None:
        ordered = _most_different(table.runs, labels, distinct)
    else:
        ordered = distinct[np.argsort(_places(table.study)[distinct], kind="stable")].tolist()
    chosen = sorted(ordered[:most])
    runs = list(table.runs.at(chosen))
    required = "none" if experiment.has_scenarios else "any"
    coefficients = leakage_coefficients(runs, InProcessEngine(), {}, required=required)  # type: ignore[arg-type]
    jobs = [
        Job(str(position), run.request.with_defaults(SENSING).parameters, coefficient, run.analysis)
        for position, (run, coefficient) in enumerate(zip(runs, coefficients, strict=True))
    ]
    return Selection(jobs, labels, len(distinct) - len(chosen), table.runs.distinct)


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


def computed_rows(jobs: Sequence[Job]) -> list[dict[str, NDArray[np.float64]]]:
    """All variables of each job, in their order."""
    grids: dict[Any, list[Job]] = {}
    for job in jobs:
        grids.setdefault((job.parameters.record, job.analysis), []).append(job)
    rows: dict[str, dict[str, Any]] = {}
    for group in (
        all_[first : first + WIDTH] for all_ in grids.values() for first in range(0, len(all_), WIDTH)
    ):
        columns = compute_columns(group)
        for position, job in enumerate(group):
            rows[job.run_id] = {
                name: values[position] for name, values in columns.items() if len(values) == len(group)
            }
    return [rows[job.run_id] for job in jobs]


@dataclass(frozen=True)
class Convergence:
    """Features under halved steps.

    Attributes
    ----------
    tolerance : float
        Largest relative change that is accepted [-].
    steps : tuple of float
        The steps tried, longest first [s].
    changes : tuple of tuple of float
        For every step, the largest relative change of each detail RMS over the runs when it is halved; NaN
        where a run failed.
    """

    tolerance: float
    steps: tuple[float, ...]
    changes: tuple[tuple[float, ...], ...]

    @property
    def good_enough(self) -> float | None:
        """The longest step tried whose halving moves no feature beyond the tolerance; None: none of them."""
        pairs = zip(self.steps, self.changes, strict=True)
        return next((step for step, change in pairs if max(change) <= self.tolerance), None)


def converge(jobs: Sequence[Job], tolerance: float) -> Convergence:
    """Halve the step of runs until none of their detail RMS moves by more than a tolerance."""
    steps: list[float] = []
    changes: list[tuple[float, ...]] = []
    coarse = np.array([row["detail_rms"] for row in computed_rows(jobs)])
    while len(steps) < MOST_HALVINGS and not (changes and max(changes[-1]) <= tolerance):
        steps.append(step := jobs[0].parameters.record.step)
        half = {"record.step": 0.5 * step}
        jobs = [replace(job, parameters=job.parameters.with_values(half)) for job in jobs]
        fine = np.array([row["detail_rms"] for row in computed_rows(jobs)])
        changes.append(tuple(np.max(np.abs(coarse / fine - 1.0), axis=0).tolist()))
        coarse = fine
    return Convergence(tolerance, tuple(steps), tuple(changes))


@dataclass(frozen=True)
class LeakageTarget:
    """A mean leakage flow and the coefficients that cause it.

    Attributes
    ----------
    flow : float
        Mean of abs(q_il) [m³/s].
    coefficient : float
        K_i of the orifice law [m^3.5/kg^0.5].
    laminar_coefficient : float
        Mean of abs(q_il) over the mean of abs(P_1 − P_2) [m³/(s·Pa)].
    piston_share : float
        Mean of abs(q_il) over the mean of A abs(v_p) [-].
    """

    flow: float
    coefficient: float
    laminar_coefficient: float
    piston_share: float


def calibrate_flows(experiment: ExperimentConfig, flows: Sequence[float]) -> list[LeakageTarget]:
    """Solve several mean leakage flows [m³/s] at once, under the experiment's baseline conditions.

    Raises
    ------
    ConfigError
        A flow cannot be reached.
    """
    sweep = SweepConfig(grid={"leakage.internal_flow": list(dict.fromkeys(flows))})
    table = expand_runs(experiment.model_copy(update={"sweep": sweep}))
    runs = table.runs[: table.n_swept]
    coefficients = leakage_coefficients(runs, InProcessEngine(), {})
    jobs = [Job(str(k), run.calibration or run.parameters, coefficients[k]) for k, run in enumerate(runs)]
    targets = []
    for job, row in zip(jobs, computed_rows(jobs), strict=True):
        mean = float(row["mean_internal_leakage_flow"])
        difference = np.mean(np.abs(row["chamber_1_pressure"] - row["chamber_2_pressure"]))
        piston = job.parameters.actuator.piston_area * np.mean(np.abs(row["piston_velocity"]))
        targets.append(
            LeakageTarget(mean, job.leakage_coefficient, float(mean / difference), float(mean / piston))
        )
    return targets
