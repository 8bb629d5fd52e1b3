"""What a sweep will do, said before it does it."""

from __future__ import annotations

import shutil
import time
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from math import prod
from pathlib import Path

from hydrofdi.config import ExperimentConfig, RunTable, expand_runs
from hydrofdi.config.idle_parameters import idle_parameters
from hydrofdi.config.plausibility import distant_baseline, unusual_values
from hydrofdi.errors import ConfigError, Mistake
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.pipeline.places import experiment_file
from hydrofdi.settings.counting import counted
from hydrofdi.settings.readable import shown_bytes
from hydrofdi.simulation import identities_of_analyses, record_identities, run_identity
from hydrofdi.simulation.kernels.lanes import WIDTH
from hydrofdi.store import Failure, ShardIndex, StoredRun, holds_enough, read_failures, read_index
from hydrofdi.store.experiment_file import computed_variables
from hydrofdi.store.layout.names import stored_signals
from hydrofdi.store.layout.outputs import dimensions

_MOST_FACTOR, _START_SECONDS = 2.0, 10.0
"""On a busy machine ready configurations took at most so many times their arithmetic, and the start [s]."""
_CALIBRATION_ROUNDS = 14
"""Simulations that a calibration takes, about."""


@dataclass(frozen=True)
class SweepPlan:
    """What a sweep will do.

    Attributes
    ----------
    experiment : ExperimentConfig
    directory : Path
        Folder of the experiment.
    table : RunTable
        The runs in their order.
    run_ids, record_ids : tuple of str
        Identities of the runs, and of their records.
    index : ShardIndex
        What is stored.
    failures : dict
        Runs that failed before without a result, by identity.
    """

    experiment: ExperimentConfig
    directory: Path
    table: RunTable
    run_ids: tuple[str, ...]
    record_ids: tuple[str, ...]
    index: ShardIndex
    failures: dict[str, Failure]

    @property
    def file(self) -> Path:
        """The experiment file."""
        return experiment_file(self.directory, self.experiment)

    @cached_property
    def missing(self) -> list[int]:
        """Positions of the runs that are neither stored with all that is asked for nor known to fail."""
        store = self.experiment.store
        return [
            position
            for position, run_id in enumerate(self.run_ids)
            if run_id not in self.failures
            and not (
                (stored := self.index.runs.get(run_id))
                and holds_enough(self.index.signals_of(stored), store.signals, store.dtype)
            )
        ]

    @cached_property
    def measurable(self) -> dict[int, StoredRun]:
        """Positions of missing runs that need no simulation → where their records are stored."""
        records = ((position, self.index.records.get(self.record_ids[position])) for position in self.missing)
        return {
            position: record
            for position, record in records
            if record is not None and not self._obstacle(record)
        }

    @cached_property
    def simulated(self) -> list[int]:
        """Positions of the missing runs whose records are to be simulated."""
        return [position for position in self.missing if position not in self.measurable]

    @property
    def n_simulated(self) -> int:
        """Number of records that are to be simulated; runs that differ only in their analysis share one."""
        return len({self.record_ids[position] for position in self.simulated})

    def reasons(self) -> dict[str, int]:
        """Why runs are to be computed → how many of them."""
        return dict(Counter(self.reason(position) for position in self.missing))

    def _obstacle(self, record: StoredRun) -> str:
        """Why a stored record cannot be measured as it is stored; empty if it can."""
        store = self.experiment.store
        if not holds_enough(record, store.signals, store.dtype):
            return "stored without the signals or the precision that the request needs"
        if record.status != "ok":
            return ""
        if lacking := sorted(self._needed_signals - stored_signals(record.signals)):
            return f"no stored signals of {', '.join(lacking)}"
        if record.dtype != "float64":
            return "stored signals in single precision, which would give different results"
        return ""

    @cached_property
    def _needed_signals(self) -> set[str]:
        from hydrofdi.execution import needed_signals

        return needed_signals(self.experiment.indicator_choice.made(self.experiment.wavelet))

    @cached_property
    def file_bytes(self) -> int:
        """Size of the experiment file before compression; the shards take as much again."""
        return len(self.run_ids) * _row_bytes(self)

    @property
    def free_bytes(self) -> int:
        """Free space at their place."""
        folder = next(path for path in (self.directory, *self.directory.resolve().parents) if path.exists())
        return shutil.disk_usage(folder).free

    @cached_property
    def warnings(self) -> list[str]:
        """What deserves a second look before the sweep starts, each said once."""
        experiment = self.experiment
        warnings = unusual_values(experiment) + distant_baseline(experiment) + idle_parameters(experiment)
        needed, free = 2 * self.file_bytes, self.free_bytes
        if needed > free:
            warnings.append(f"needs {shown_bytes(needed)}, of which {shown_bytes(free)} are free")
        for sample in (self.experiment.ensemble.sample, self.experiment.sweep.sample):
            if sample and sample.method == "sobol" and sample.count & (sample.count - 1):
                warnings.append(
                    f"a Sobol sample of {counted(sample.count, 'point')} is not balanced; take a power of two"
                )
        from hydrofdi.assessment.indicator_warnings import indicator_warnings, other_machine_warnings
        from hydrofdi.assessment.plan_warnings import plan_warnings
        from hydrofdi.assessment.study_warnings import study_warnings

        runs = self.table.runs
        warnings += plan_warnings(runs.distinct, runs.choice) + indicator_warnings(runs.distinct, runs.choice)
        warnings += other_machine_warnings(self.experiment) + study_warnings(self.experiment)
        warnings += [f"damaged: {text}" for text in self.index.damaged.values()]
        return list(dict.fromkeys(warnings))

    def reason(self, position: int) -> str:
        """Why a missing run is to be computed."""
        run_id = self.run_ids[position]
        if run_id in self.index.runs:
            return "stored without the signals or the precision that the request needs"
        if run_id in self.index.lost:
            return "its shard is damaged"
        if (record := self.index.records.get(self.record_ids[position])) is not None:
            return f"another analysis of a stored record{_because(self._obstacle(record))}"
        for version in sorted(self.index.physics_versions - {PHYSICS_VERSION}):
            if run_identity(self.table.runs[position], version) in self.index.runs:
                return f"physics version changed from {version} to {PHYSICS_VERSION}"
        return "new"


def _because(obstacle: str) -> str:
    return f", simulated again ({obstacle})" if obstacle else ", measured from its stored signals"


def plan_sweep(
    experiment: ExperimentConfig,
    directory: Path,
    *,
    retry_failed: bool = False,
    run_ids: tuple[str, ...] | None = None,
) -> SweepPlan:
    """The runs of an experiment, and which of them are stored. Writes nothing.

    Parameters
    ----------
    experiment : ExperimentConfig
    directory : Path
        Folder of the experiment.
    retry_failed : bool
        Whether runs that failed without a result count as missing.
    run_ids : tuple of str, optional
        The identities of its runs, where an indicator is not installed that belongs to them.

    Raises
    ------
    ConfigError
        The sweep is impossible.
    """
    table = expand_runs(experiment)
    records = [run.record for run in table.runs.distinct("record")]
    time_grids = {(record.n_sample, record.sampling_frequency) for record in records}
    if experiment.store.signals != "none" and len(time_grids) > 1:
        message = (
            "signals with different durations or sampling frequencies cannot be stored in one data set;"
            " set store: {signals: none}"
        )
        raise ConfigError([Mistake(message, "store.signals")])
    record_ids = record_identities(table.runs)
    run_ids = run_ids or identities_of_analyses(table.runs, record_ids)
    failures = {} if retry_failed else read_failures(directory)
    return SweepPlan(experiment, directory, table, run_ids, record_ids, read_index(directory), failures)


def predict_seconds(plan: SweepPlan, workers: int) -> tuple[float, float]:
    """Least and most wall time to expect of a plan [s].

    A few of its runs are simulated without their leakage. The least is the time of the arithmetic; workers
    that start, storing, and a busy machine add to it.
    """
    least = _least_seconds(plan, workers)
    return least, _MOST_FACTOR * least + _START_SECONDS if least else 0.0


def _least_seconds(plan: SweepPlan, workers: int) -> float:
    runs = plan.table.runs.at(plan.simulated)
    if not runs:
        return 0.0
    from hydrofdi.execution import Job, compute_columns
    from hydrofdi.execution.batching import batch_shape

    jobs = [
        Job.of(run, "", run.parameters.leakage.internal_coefficient or 0.0) for run in islice(runs, 4 * WIDTH)
    ]
    jobs = [job for job in jobs if batch_shape(job) == batch_shape(jobs[0])][:WIDTH]
    compute_columns(jobs)  # compiles, or loads their kernels
    start = time.perf_counter()
    compute_columns(jobs)
    seconds = time.perf_counter() - start
    blocks = -(-len(runs) // WIDTH) + _CALIBRATION_ROUNDS * -(-runs.solutions().total // WIDTH)
    return max(seconds, blocks * seconds * WIDTH / max(len(jobs), WIDTH) / workers)


def _row_bytes(plan: SweepPlan) -> int:
    """Bytes that a run takes in the experiment file."""
    store, sizes = plan.experiment.store, dimensions(plan.table.runs)
    n_sample = plan.table.runs[0].parameters.record.n_sample
    n_signal = len(stored_signals(store.signals))
    n_number = sum(
        prod(sizes[name] for name in variable.dimensions[1:]) for variable in computed_variables(plan.table)
    )
    return 8 * n_number + (4 if store.dtype == "float32" else 8) * n_sample * n_signal
