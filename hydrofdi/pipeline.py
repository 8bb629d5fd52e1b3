"""From an experiment to stored results: plan, calibrate, run, collect."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path

import hydrofdi
from hydrofdi.config import ExperimentConfig, RunParameters, RunSpec, RunTable, expand_runs
from hydrofdi.errors import ConfigError, Mistake, ReportError
from hydrofdi.execution import (
    Batch,
    BatchReceipt,
    Engine,
    InProcessEngine,
    Job,
    LocalPoolEngine,
    available_cores,
    compute_columns,
    compute_shard,
    split_jobs,
)
from hydrofdi.simulation import Calibration, run_identity, solve_leakage_coefficients
from hydrofdi.simulation.lanes import WIDTH
from hydrofdi.store import Columns, ShardColumns, ShardRow, index_shards, write_experiment
from hydrofdi.units import convert

RESULTS = Path("results")
"""Folder for experiments, below the working directory."""

_LIBRARIES = ("h5py", "numba", "numpy", "pywavelets", "scipy")

_SIGNALS_HELD = {"none": 0, "pressures": 1, "all": 2}


@dataclass(frozen=True)
class SweepPlan:
    """What a sweep has to do.

    Attributes
    ----------
    experiment : ExperimentConfig
    directory : Path
        Folder of the experiment.
    table : RunTable
        The runs in their order.
    run_ids : tuple of str
        Their identities.
    stored : dict
        Runs that are stored already, by identity.
    """

    experiment: ExperimentConfig
    directory: Path
    table: RunTable
    run_ids: tuple[str, ...]
    stored: dict[str, ShardRow]

    @property
    def file(self) -> Path:
        """The experiment file."""
        return self.directory / f"{self.directory.name}.h5"

    @cached_property
    def missing(self) -> list[int]:
        """Positions of the runs that are not stored, or not with the signals that are asked for."""
        wanted = _SIGNALS_HELD[self.experiment.store.signals]
        return [
            position
            for position, run_id in enumerate(self.run_ids)
            if run_id not in self.stored or _SIGNALS_HELD[self.stored[run_id].signals] < wanted
        ]


@dataclass(frozen=True)
class SweepSummary:
    """What a sweep did: numbers of runs, wall time [s], and the experiment file."""

    planned: int
    completed: int
    skipped: int
    failed: int
    seconds: float
    file: Path


@dataclass(frozen=True)
class SingleRun:
    """One simulated run.

    Attributes
    ----------
    table : RunTable
        With this run alone.
    columns : mapping
        Its variables, with one row.
    """

    table: RunTable
    columns: Columns


def experiment_directory(experiment: ExperimentConfig, out: Path | None = None) -> Path:
    """Folder of an experiment: `out`, or ``results/<name>``."""
    return RESULTS / experiment.name if out is None else out


def newest_experiment_file(directory: Path | None) -> Path:
    """The experiment file in a folder, or the newest one below ``results/``.

    Raises
    ------
    ReportError
        There is none.
    """
    if directory is not None and not directory.is_dir():
        return directory
    pattern, root = ("*/*.h5", RESULTS) if directory is None else ("*.h5", directory)
    files = [file for file in root.glob(pattern) if not file.name.startswith(".")]
    if not files:
        where = f"{root}/*" if directory is None else str(directory)
        raise ReportError(f"no experiment file in {where}; run 'hydrofdi sweep CONFIG' first")
    return max(files, key=lambda file: file.stat().st_mtime_ns)


def plan_sweep(experiment: ExperimentConfig, directory: Path) -> SweepPlan:
    """The runs of an experiment, and which of them are stored.

    Raises
    ------
    ConfigError
        The sweep is impossible.
    """
    table = expand_runs(experiment)
    time_grids = {run.parameters.run for run in table.runs}
    if experiment.store.signals != "none" and len(time_grids) > 1:
        raise ConfigError(
            [
                Mistake(
                    "signals with different durations or sampling do not fit into one data set;"
                    " set store: {signals: none}",
                    "store.signals",
                )
            ]
        )
    run_ids = tuple(run_identity(run) for run in table.runs)
    return SweepPlan(experiment, directory, table, run_ids, index_shards(directory))


def run_sweep(
    plan: SweepPlan, workers: int | None = None, on_progress: Callable[[BatchReceipt], None] | None = None
) -> SweepSummary:
    """Compute the missing runs of a plan and build its experiment file.

    Parameters
    ----------
    plan : SweepPlan
    workers : int, optional
        Number of processes; by default the cores that this process may use.
    on_progress : callable, optional
        Called after each batch.

    Raises
    ------
    ConfigError
        A leakage flow cannot be reached; nothing is written then.
    StoreError
        The results cannot be written.
    """
    start = time.perf_counter()
    workers = workers or available_cores()
    if plan.missing:
        with _engine(workers) as engine:
            _run_missing(plan, engine, workers, on_progress)
    rows = index_shards(plan.directory)
    ordered = [rows[run_id] for run_id in plan.run_ids]
    columns = ShardColumns(ordered, plan.experiment.store.signals)
    if plan.missing or not plan.file.exists():
        write_experiment(plan.file, plan.experiment, plan.table, columns, library_versions())
    return SweepSummary(
        planned=len(plan.run_ids),
        completed=len(plan.missing),
        skipped=len(plan.run_ids) - len(plan.missing),
        failed=sum(row.status != "ok" for row in ordered),
        seconds=time.perf_counter() - start,
        file=plan.file,
    )


def _engine(workers: int) -> Engine:
    return InProcessEngine() if workers == 1 else LocalPoolEngine(workers)


def _run_missing(
    plan: SweepPlan, engine: Engine, workers: int, on_progress: Callable[[BatchReceipt], None] | None
) -> None:
    runs = [plan.table.runs[position] for position in plan.missing]
    coefficients = leakage_coefficients(runs, engine)
    jobs = [
        Job(plan.run_ids[position], run.parameters, coefficient)
        for position, run, coefficient in zip(plan.missing, runs, coefficients, strict=True)
    ]
    batches = [
        Batch(batch, plan.directory, plan.experiment.store.signals) for batch in split_jobs(jobs, workers)
    ]
    for receipt in engine.results(compute_shard, batches):
        if on_progress is not None:
            on_progress(receipt)


def leakage_coefficients(runs: Sequence[RunSpec], engine: Engine) -> list[float]:
    """K_i of each run [m^3.5/kg^0.5]: as given, or solved from the leakage flow.

    Raises
    ------
    ConfigError
        Some leakage flows cannot be reached.
    """
    conditions = list(dict.fromkeys(run.calibration for run in runs if run.calibration is not None))
    groups = [tuple(conditions[first : first + WIDTH]) for first in range(0, len(conditions), WIDTH)]
    solved = dict(pair for pairs in engine.results(_calibrate, groups) for pair in pairs)
    _require_reachable(solved)
    return [
        solved[run.calibration].coefficient
        if run.calibration is not None
        else run.parameters.leakage.internal_coefficient or 0.0
        for run in runs
    ]


def _calibrate(conditions: tuple[RunParameters, ...]) -> list[tuple[RunParameters, Calibration]]:
    return list(zip(conditions, solve_leakage_coefficients(conditions), strict=True))


def _require_reachable(solved: dict[RunParameters, Calibration]) -> None:
    unreachable = {
        (condition.leakage.internal_flow or 0.0, calibration.reachable_flow)
        for condition, calibration in solved.items()
        if calibration.coefficient != calibration.coefficient
    }
    if unreachable:
        raise ConfigError(
            [
                Mistake(
                    f"no K_i gives a mean leakage of {convert(flow, 'L/min'):.4g} L/min;"
                    f" the most that this actuator leaks is {convert(most, 'L/min'):.3g} L/min",
                    "leakage.internal_flow",
                )
                for flow, most in sorted(unreachable)
            ]
        )


def simulate_nominal(experiment: ExperimentConfig) -> SingleRun:
    """Simulate the nominal run of an experiment, its sweep left aside.

    Raises
    ------
    ConfigError
        Its leakage flow cannot be reached.
    """
    alone = experiment.model_copy(update={"sweep": type(experiment.sweep)()})
    run = expand_runs(alone).runs[0]
    (coefficient,) = leakage_coefficients([run], InProcessEngine())
    columns = compute_columns([Job(run_identity(run), run.parameters, coefficient)])
    return SingleRun(RunTable((run,), {}, 1, (0,), (0,)), columns)


def write_single_run(path: Path, experiment: ExperimentConfig, single: SingleRun) -> None:
    """Store a simulated run as an experiment file.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    write_experiment(path, experiment, single.table, single.columns, library_versions())


def library_versions() -> dict[str, str]:
    """Versions of hydrofdi, Python and the libraries that numbers depend on."""
    versions = {name: version(name) for name in _LIBRARIES}
    return versions | {"hydrofdi": hydrofdi.__version__, "python": platform.python_version()}
