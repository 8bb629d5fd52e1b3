"""The work of one task: simulate a batch of runs or read their records, measure them, write their shard."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters, RunSpec
from hydrofdi.config.experiment import DEFAULT_ANALYSIS, Analysis, Indicators, StoreConfig
from hydrofdi.config.plant import absent_signals
from hydrofdi.engine import Engine, InProcessEngine, TaskFailure, halves, run_halving
from hydrofdi.errors import Issue
from hydrofdi.indicators.measuring import Seconds, measure, used_channels
from hydrofdi.quality.doubts import Simulated, how_records_settle, numbers_of_doubts, pressure_features
from hydrofdi.quality.machine import hydraulic_mode, mean_external_leakage_flows
from hydrofdi.records import RecordBatch
from hydrofdi.simulation.balances import RunOutcome, Trajectory, balance_residuals
from hydrofdi.simulation.batch import simulate_batch
from hydrofdi.simulation.calibration import unreachable_sentence
from hydrofdi.simulation.lanes import WIDTH, indices, positions_by
from hydrofdi.simulation.sensing import Measurement
from hydrofdi.store import names
from hydrofdi.store.experiment_data import SIGNAL_OF_CHANNEL
from hydrofdi.store.folder import Failure, write_failure, write_log
from hydrofdi.store.shards import StoredRun, gathered, write_shard
from hydrofdi.store.verdicts import SETTLED_CHANGE, verdicts_of

Columns = dict[str, NDArray[Any]]
"""Variable of a shard → array with one row per job; ``time`` → sampling instants [s]."""


@dataclass(frozen=True)
class Job:
    """A run that is ready to be computed.

    `leakage_coefficient` is K_i [m^3.5/kg^0.5], NaN if none gives its leakage; `stored` is where its record
    is, None if it is to be simulated.
    """

    run_id: str
    parameters: RunParameters
    leakage_coefficient: float
    analysis: Analysis = DEFAULT_ANALYSIS
    record_id: str = ""
    stored: StoredRun | None = None

    @classmethod
    def of(cls, run: RunSpec, run_id: str, leakage_coefficient: float, record_id: str = "") -> Job:
        """The job of a run."""
        return cls(run_id, run.parameters, leakage_coefficient, run.analysis, record_id)


def needed_signals(indicators: Indicators) -> set[str]:
    """The signals that are measured: those of the indicators, and the chamber-1 pressure."""
    needed = used_channels(indicators) & SIGNAL_OF_CHANNEL.keys()
    return {SIGNAL_OF_CHANNEL[channel] for channel in needed} | {names.CHAMBER_1_PRESSURE}


def measured_columns(
    jobs: Sequence[Job], records: Columns, seconds: Seconds | None = None
) -> dict[str, NDArray[Any]]:
    """What is measured of the records of jobs, one row per job; NaN if a run failed."""
    columns: dict[str, NDArray[Any]] = {}
    alike = positions_by((job.analysis, job.parameters.drive_period) for job in jobs)
    for (analysis, _), rows in alike.items():
        own = {name: values[rows] for name, values in records.items() if name != names.TIME}
        part = _measured_alike([jobs[row] for row in rows], analysis, own, seconds)
        insert(columns, rows, len(jobs), part)
    failed = records[names.STATUS] != "ok"
    for name, values in columns.items():
        if values.dtype == float:
            values[failed] = np.nan
        elif name.endswith(names.OBSTACLE):
            values[failed] = records[names.MESSAGE][failed]
    return columns | names.wavelet_numbers(columns)


def _measured_alike(
    jobs: Sequence[Job], analysis: Analysis, records: Columns, seconds: Seconds | None
) -> dict[str, NDArray[Any]]:
    identities = [analysis.identities(job.record_id) for job in jobs]
    columns: dict[str, NDArray[Any]] = {
        f"{label}{names.ANALYSIS_ID}": np.array([by_label[label] for by_label in identities], dtype=object)
        for label in analysis.indicators
    }
    batch = _record_batch(jobs, analysis.indicators, records).window(analysis.n_discarded)
    measures = measure(batch, analysis.indicators, seconds)
    for label, reasons in measures.obstacles.items():
        columns[f"{label}{names.OBSTACLE}"] = np.array([reason or "" for reason in reasons], dtype=object)
    pressure = np.ascontiguousarray(records[names.CHAMBER_1_PRESSURE])
    with np.errstate(all="ignore"):
        features = pressure_features(
            [job.parameters for job in jobs], analysis, pressure, records[names.SETTLED_FROM]
        )
    return columns | measures.values | features


def _record_batch(jobs: Sequence[Job], indicators: Indicators, records: Columns) -> RecordBatch:
    """What the sensors show of records, as far as indicators need it."""
    needed = used_channels(indicators)
    return RecordBatch(
        {
            channel: records[signal]
            for channel, signal in SIGNAL_OF_CHANNEL.items()
            if channel in needed and signal in records
        },
        jobs[0].parameters.record.sampling_frequency,
        tuple(job.record_id for job in jobs),
        drive_period=jobs[0].parameters.drive_period,
        remarks=tuple(
            () if status == "ok" else (Issue(message, kind=status, is_unusable=True),)
            for status, message in zip(records[names.STATUS], records[names.MESSAGE], strict=True)
        ),
    )


def insert(
    columns: dict[str, NDArray[Any]], rows: list[int], n_job: int, part: Mapping[str, NDArray[Any]]
) -> None:
    """Put the numbers of some rows in their places; those of different shapes lie in the largest."""
    for name, values in part.items():
        whole = columns.get(name)
        # Batches may differ in their number of levels or phases: the largest holds all, NaN elsewhere.
        sizes = np.maximum(values.shape[1:], whole.shape[1:] if whole is not None else 0)
        shape = (n_job, *np.atleast_1d(sizes).astype(int)[: values.ndim - 1])
        is_text = values.dtype == object
        if whole is None or whole.shape != shape:
            larger = np.full(shape, "" if is_text else np.nan, values.dtype)
            if whole is not None:
                larger[tuple(slice(size) for size in whole.shape)] = whole
            columns[name] = whole = larger
        inside: list[Any] = [rows, *(slice(size) for size in values.shape[1:])]
        whole[tuple(inside)] = values


@dataclass(frozen=True)
class Batch:
    """Jobs of one time axis that are stored in one shard: all to be simulated, or all with stored records."""

    jobs: tuple[Job, ...]
    directory: Path
    store: StoreConfig

    @property
    def is_stored(self) -> bool:
        """Whether the records are stored and only measured."""
        return self.jobs[0].stored is not None

    def halves(self) -> list[Batch]:
        """Two batches of half the jobs each; none of a single job."""
        return [replace(self, jobs=tuple(part)) for part in halves(self.jobs)]


@dataclass(frozen=True)
class BatchReceipt:
    """What a finished batch says of itself; `seconds` is CPU time by label of indicator."""

    n_run: int
    n_failed: int
    shard: Path
    seconds: Seconds = field(default_factory=dict)


def compute_shard(batch: Batch) -> BatchReceipt:
    """Measure the records of a batch, simulated or stored, and write its shard."""
    seconds: Seconds = {}
    store = batch.store.model_copy(update={"signals": "none"}) if batch.is_stored else batch.store
    columns = _columns(batch, store.signals != "none", seconds)
    shard = write_shard(batch.directory, columns, store)
    n_failed = sum(status != "ok" for status in columns[names.STATUS])
    return BatchReceipt(len(batch.jobs), n_failed, shard, seconds)


def _columns(batch: Batch, keeps_signals: bool, seconds: Seconds) -> Columns:
    """Variables of a batch; one that keeps no signals is computed in parts that fit the cache."""
    n_job = len(batch.jobs)
    if keeps_signals:
        return compute_columns(batch.jobs, seconds=seconds)
    columns: Columns = {}
    at_once = _most_jobs(batch.jobs[0].parameters.record.n_sample, _MOST_SAMPLES)
    for first in range(0, n_job, at_once):
        rows = range(n_job)[first : first + at_once]
        part = compute_columns(batch.jobs[first : first + at_once], seconds=seconds)
        numbers = {name: values for name, values in part.items() if name not in (*names.SIGNALS, names.TIME)}
        insert(columns, list(rows), n_job, numbers)
    return columns


def compute_columns(jobs: Sequence[Job], *, seconds: Seconds | None = None) -> Columns:
    """All variables of a shard, one row per job, and the time axis; shared records are simulated once.

    If the records are stored, nothing is simulated and signals are left out. CPU times [s] of the indicators
    are added to `seconds` by label.
    """
    records = _simulated(jobs) if jobs[0].stored is None else _stored(jobs)
    identities = {
        names.RUN_ID: np.array([job.run_id for job in jobs], dtype=object),
        names.RECORD_ID: np.array([job.record_id for job in jobs], dtype=object),
    }
    return records | identities | measured_columns(jobs, records, seconds)


def _stored(jobs: Sequence[Job]) -> Columns:
    wanted = set().union(*(needed_signals(job.analysis.indicators) for job in jobs))
    variables = [
        variable
        for variable in names.stored_variables("all")
        if (variable.name in wanted if variable.is_signal else variable.name not in names.FEATURES)
    ]
    sizes = {names.TIME: jobs[0].parameters.record.n_sample}
    return gathered([job.stored for job in jobs], variables, sizes)


def _simulated(jobs: Sequence[Job]) -> Columns:
    """Records of jobs; those that differ in their analysis alone share one."""
    if analysed_alike(jobs):
        return _recorded(jobs)
    records_of = positions_by((job.parameters.text(), job.leakage_coefficient.hex()) for job in jobs)
    records = _recorded([jobs[rows[0]] for rows in records_of.values()])
    record_of_job = indices(records_of, len(jobs))
    return {name: v if name == names.TIME else v[record_of_job] for name, v in records.items()}


def analysed_alike(jobs: Sequence[Job]) -> bool:
    """Whether jobs differ in more than the analysis of their record, so that each has a record of its own."""
    return all(job.analysis == jobs[0].analysis for job in jobs)


def simulated(
    parameters: Sequence[RunParameters], coefficients: Sequence[float]
) -> tuple[Trajectory, Trajectory]:
    """Trajectories of runs with these leakage coefficients K_i, and what their sensors show [SI]."""
    sensors, given = Measurement(parameters), np.array(coefficients, dtype=float)
    # A run whose leak is unreachable (NaN) is simulated sealed beside the others, and then marked as failed.
    trajectory = simulate_batch(parameters, np.nan_to_num(given).tolist(), tap=sensors)
    outcomes = tuple(
        RunOutcome("unreachable_leakage", unreachable_sentence(run)) if math.isnan(coefficient) else outcome
        for run, coefficient, outcome in zip(parameters, given, trajectory.outcomes, strict=True)
    )
    trajectory = replace(trajectory, leakage_coefficient=given, outcomes=outcomes)
    return trajectory, sensors.show(trajectory)


def _recorded(jobs: Sequence[Job]) -> Columns:
    """Records: what the sensors show, and what is known of the plant itself."""
    parameters = [job.parameters for job in jobs]
    trajectory, measured = simulated(parameters, [job.leakage_coefficient for job in jobs])
    with np.errstate(all="ignore"):
        numbers = _plant_numbers(parameters, trajectory)
        pressure, damping = trajectory.chamber_1_pressure, numbers[names.MODE_DAMPING_RATIO]
        changes, numbers["settled_from"] = how_records_settle(parameters, pressure, SETTLED_CHANGE)
        doubts = numbers_of_doubts(Simulated(parameters, trajectory, measured, changes, damping))
    outcomes = trajectory.outcomes
    statuses = [outcome.status for outcome in outcomes]
    verdicts = verdicts_of(statuses, doubts)
    failed = np.array([not outcome.is_ok for outcome in outcomes])
    for values in (*numbers.values(), *doubts.values()):
        values[failed] = np.nan
    return {
        names.STATUS: np.array(statuses, dtype=object),
        names.MESSAGE: np.array([outcome.message for outcome in outcomes], dtype=object),
        names.LEAKAGE_COEFFICIENT: trajectory.leakage_coefficient,
        names.TIME: trajectory.time,
        **measured.signals(name for name in names.SIGNALS if name not in absent_signals(parameters[0].plant)),
        **numbers,
        names.VERDICT: np.array(verdicts, dtype=object),
        **doubts,
    }


def _plant_numbers(
    parameters: Sequence[RunParameters], trajectory: Trajectory
) -> dict[str, NDArray[np.float64]]:
    """What is known of the plant itself, over the whole record; of an FMU its equations are unknown."""
    known = [*names.EXTERNAL_LEAKAGE_FLOWS, "volume_residual", "energy_residual"]
    known += [names.MODE_FREQUENCY, names.MODE_DAMPING_RATIO]
    values = np.full((len(known), len(parameters)), np.nan)
    if parameters[0].plant.fmu is None:
        values[:2] = mean_external_leakage_flows(parameters, trajectory)
        values[2:4] = balance_residuals(parameters, trajectory)
        modes = [hydraulic_mode(run, trajectory, row) for row, run in enumerate(parameters)]
        values[4:] = np.transpose([(mode.frequency, mode.damping_ratio) for mode in modes])
    numbers = {names.MEAN_LEAKAGE_FLOW: trajectory.mean_internal_leakage_flow}
    numbers |= dict(zip(known, values, strict=True))
    for variable in names.EXTREMES:
        signal, _, kind = variable.name.rpartition("_")
        numbers[variable.name] = getattr(getattr(trajectory, signal), kind)(axis=1)
    return numbers


_LARGEST_BATCH = 32 * WIDTH
"""Jobs."""

_BATCHES_PER_WORKER = 8
_MOST_SAMPLES = 320_000
"""Samples of one signal that are simulated at once. More leave the processor's cache and gain nothing."""

_MOST_SAMPLES_OF_SHARD = 5 * _MOST_SAMPLES
"""Samples of one signal behind a shard without signals. They take about a second, after which progress is
shown and results are stored."""


def split_jobs(jobs: Sequence[Job], workers: int, *, keeps_signals: bool = True) -> list[tuple[Job, ...]]:
    """Batches of jobs, each of one shard, in whole lanes; results do not depend on the split."""
    most_samples = _MOST_SAMPLES if keeps_signals else _MOST_SAMPLES_OF_SHARD
    batches: list[tuple[Job, ...]] = []
    for group in _compatible_groups(jobs):
        most = _most_jobs(group[0].parameters.record.n_sample, most_samples)
        size = _batch_size(len(group), most, workers)
        if group[0].parameters.plant.fmu is not None:  # no lanes: short tasks lose little
            size = max(1, -(-len(group) // (workers * _BATCHES_PER_WORKER)))
        batches.extend(tuple(group[first : first + size]) for first in range(0, len(group), size))
    return batches


def _compatible_groups(jobs: Sequence[Job]) -> list[list[Job]]:
    """Jobs of the same time axis and the same shape of features; those of one record stand together."""
    groups = []
    for rows in positions_by(map(batch_shape, jobs)).values():
        group = [jobs[row] for row in rows]
        if not analysed_alike(group):
            of_record = positions_by(job.parameters.text() for job in group)
            group = [group[row] for rows in of_record.values() for row in rows]
        groups.append(group)
    return groups


def batch_shape(job: Job) -> Hashable:
    """What jobs must share so that one task can compute them and one shard can contain them."""
    wavelet = job.analysis.wavelet
    time_axis, plant = job.parameters.record.time_axis, job.parameters.plant.digest
    return plant, time_axis, wavelet.levels, wavelet.phase == "all", job.stored is None


def _most_jobs(n_sample: int, most_samples: int) -> int:
    # Whole lanes, so that no lane of the kernel idles.
    return max(WIDTH, min(_LARGEST_BATCH, most_samples // n_sample // WIDTH * WIDTH))


def _batch_size(n_job: int, largest: int, workers: int) -> int:
    if n_job <= workers * WIDTH:
        return max(1, -(-n_job // workers))
    # −(−a // b) rounds up in integers.
    even = -(-n_job // (workers * _BATCHES_PER_WORKER))
    return min(largest, -(-even // WIDTH) * WIDTH)


class Recorder:
    """What has ended of the jobs of a sweep, or of a part of one: it keeps log, failures and progress."""

    def __init__(self, directory: Path, part: str, advance: Callable[[int, int], object]) -> None:
        self._directory, self._advance = directory, advance
        self.log = partial(write_log, directory / f"run{part}.log")
        self._receipts: list[BatchReceipt] = []
        self._n_lost = 0

    def stored(self, receipt: BatchReceipt) -> None:
        """A batch is stored."""
        self._receipts.append(receipt)
        self.log("stored", shard=receipt.shard.name, runs=receipt.n_run, failed=receipt.n_failed)
        self._advance(receipt.n_run, receipt.n_failed)

    def failed(self, job: Job, failure: TaskFailure) -> None:
        """A job gave no result."""
        self._n_lost += 1
        write_failure(self._directory, Failure(job.run_id, failure.status, failure.message, failure.log))
        self.log("failed", run=job.run_id, status=failure.status, message=failure.message)
        self._advance(1, 1)

    @property
    def completed(self) -> int:
        """Number of runs that have ended, with or without a result."""
        return sum(receipt.n_run for receipt in self._receipts) + self._n_lost

    @property
    def shards(self) -> frozenset[str]:
        """Names of the shards that are stored."""
        return frozenset(receipt.shard.name for receipt in self._receipts)

    @property
    def costs(self) -> dict[str, float]:
        """Label of an indicator → CPU time per record [s]."""
        seconds = Counter[str]()
        for receipt in self._receipts:
            seconds.update(receipt.seconds)
        n_measured = sum(receipt.n_run for receipt in self._receipts)
        return {label: total / n_measured for label, total in seconds.items()}


def run_jobs(
    engine: Engine,
    jobs: Sequence[Job],
    directory: Path,
    store: StoreConfig,
    time_per_job: float | None,
    recorder: Recorder,
) -> None:
    """Run jobs in batches; a batch that fails is halved until its failing jobs stand alone.

    `time_per_job` [s] is shared by runs that lie side by side in lanes. Stored records are measured in this
    process if the engine's workers do not reach the folder. An error of the user, such as a full disk, ends
    all.
    """

    def time_limit(batch: Batch) -> float | None:
        at_once = WIDTH if batch.jobs[0].parameters.plant.fmu is None else 1
        return None if time_per_job is None else time_per_job * -(-len(batch.jobs) // at_once)

    split = split_jobs(jobs, engine.workers, keeps_signals=store.signals != "none")
    batches = [Batch(batch, directory, store) for batch in split]
    here = [batch for batch in batches if batch.is_stored and not engine.reads_results]
    there = [batch for batch in batches if batch not in here]
    for runner, work in ((InProcessEngine(), here), (engine, there)):
        for result in run_halving(runner, compute_shard, work, Batch.halves, time_limit):
            if result.failure is None:
                recorder.stored(result.value)
            else:
                recorder.failed(result.item.jobs[0], result.failure)
