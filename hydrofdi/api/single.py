"""A single run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hydrofdi.api.stored import library_versions
from hydrofdi.config import ExperimentConfig, RunSpec, RunTable, expand_runs
from hydrofdi.config.study.detection import DetectionConfig
from hydrofdi.config.sweeps.sweep import SweepConfig
from hydrofdi.execution import InProcessEngine, Job, compute_columns, leakage_coefficients
from hydrofdi.simulation import record_identity, run_identity
from hydrofdi.store import Columns, HeldResults, write_experiment
from hydrofdi.store.layout.names import NO_BASELINE


@dataclass(frozen=True)
class SingleRun:
    """One simulated run: what was asked for, and its variables with one row."""

    run: RunSpec
    columns: Columns


def simulate_nominal(experiment: ExperimentConfig) -> SingleRun:
    """Simulate the nominal run of an experiment, its sweep left aside.

    Raises
    ------
    ConfigError
        Its leakage flow cannot be reached.
    """
    run = expand_runs(_alone(experiment)).runs[0]
    (coefficient,) = leakage_coefficients([run], InProcessEngine(), {})
    job = Job.of(run, run_identity(run), coefficient, record_identity(run))
    return SingleRun(run, compute_columns([job]))


def _alone(experiment: ExperimentConfig) -> ExperimentConfig:
    """An experiment without what it varies; the one run of a study keeps its signals."""
    alone: dict[str, Any] = {"sweep": SweepConfig(), "ensemble": SweepConfig(), "study": None}
    if experiment.study is not None and experiment.store.signals == "none":
        alone["store"] = experiment.store.model_copy(update={"signals": "all"})
    return experiment.model_copy(update=alone | {"detection": DetectionConfig()})


def write_single_run(path: Path, experiment: ExperimentConfig, single: SingleRun) -> None:
    """Store a simulated run as an experiment file. A healthy one is its own baseline, others have none.

    Raises
    ------
    StoreError
        The file cannot be written.
    """
    alone = _alone(experiment)
    whole = expand_runs(alone)
    fixed, matched = (
        np.where(rows[:1] == 0, 0, NO_BASELINE) for rows in (whole.fixed_baseline, whole.matched_baseline)
    )
    table = RunTable(whole.runs[:1], {}, 1, fixed, matched, np.array([NO_BASELINE]))
    write_experiment(path, alone, table, HeldResults(single.columns), library_versions())
