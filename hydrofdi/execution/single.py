"""A single run: it is computed in this process, and stored as an experiment of its own."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from hydrofdi.config import ExperimentConfig, RunSpec, RunTable, expand_runs
from hydrofdi.config.runs import record_identity, run_identity
from hydrofdi.config.study import DetectionConfig
from hydrofdi.config.sweep import SweepConfig
from hydrofdi.engine import limited
from hydrofdi.execution.compute import Job, compute_columns
from hydrofdi.simulation.calibration import leakage_coefficients
from hydrofdi.store import names
from hydrofdi.store.experiment_file import write_experiment
from hydrofdi.store.results import library_versions
from hydrofdi.store.shards import Columns, ShardResults, read_index, write_shard


def compute_run(experiment: ExperimentConfig) -> tuple[RunSpec, Columns]:
    """The first run of an experiment without what it varies, and its variables."""
    spec = expand_runs(_alone(experiment)).runs[0]
    with limited(experiment.limits.time_per_job):
        (coefficient,) = leakage_coefficients([spec])
        job = Job.of(spec, run_identity(spec), coefficient, record_identity(spec))
        return spec, compute_columns([job])


def store_run(path: Path, experiment: ExperimentConfig, columns: Columns) -> None:
    """Write an experiment file with one run; a healthy one is its own baseline, others have none."""
    alone = _alone(experiment)
    whole = expand_runs(alone)
    fixed, matched = (
        np.where(rows[:1] == 0, 0, names.NO_BASELINE)
        for rows in (whole.fixed_baseline, whole.matched_baseline)
    )
    table = RunTable(whole.runs[:1], {}, 1, fixed, matched)
    with TemporaryDirectory() as folder:
        write_shard(Path(folder), columns, alone.store)
        results = ShardResults([str(columns[names.RUN_ID][0])], read_index(Path(folder)), {})
        write_experiment(path, alone, table, results, library_versions())


def _alone(experiment: ExperimentConfig) -> ExperimentConfig:
    """An experiment without what it varies; the one run of a study keeps its signals."""
    alone: dict[str, Any] = {"sweep": SweepConfig(), "ensemble": SweepConfig(), "study": None}
    if experiment.study is not None and experiment.store.signals == "none":
        alone["store"] = experiment.store.model_copy(update={"signals": "all"})
    return experiment.model_copy(update=alone | {"detection": DetectionConfig()})
