"""How jobs are dealt out; a batch that fails is halved until the run is found that fails."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from hydrofdi.errors import HydrofdiError
from hydrofdi.execution.compute import Batch, BatchReceipt, analysed_alike, compute_shard
from hydrofdi.execution.engine import Engine, TaskFailure
from hydrofdi.execution.measuring import Job
from hydrofdi.simulation.kernels.lanes import WIDTH

_LARGEST_BATCH = 32 * WIDTH
"""Jobs."""

_BATCHES_PER_WORKER = 8
_MOST_SAMPLES = 320_000
"""Samples of one signal in a batch. Larger ones leave the processor's cache and gain nothing; these take a
fraction of a second, after which progress is shown and results are stored."""


def split_jobs(jobs: Sequence[Job], workers: int) -> list[tuple[Job, ...]]:
    """Batches of jobs that fit into one simulation, balanced over the workers.

    Batches are whole numbers of lane widths if there are enough jobs. Results do not depend on the split.
    """
    batches: list[tuple[Job, ...]] = []
    for group in _compatible_groups(jobs):
        size = _batch_size(len(group), group[0].parameters.record.n_sample, workers)
        batches.extend(tuple(group[first : first + size]) for first in range(0, len(group), size))
    return batches


def _compatible_groups(jobs: Sequence[Job]) -> list[list[Job]]:
    """Jobs of the same time axis and the same shape of features; those of one record stand together."""
    groups: dict[object, list[Job]] = {}
    for job in jobs:
        groups.setdefault(batch_shape(job), []).append(job)
    return [group if analysed_alike(group) else _by_record(group) for group in groups.values()]


def _by_record(jobs: Sequence[Job]) -> list[Job]:
    records: dict[str, list[Job]] = {}
    for job in jobs:
        records.setdefault(job.parameters.text(), []).append(job)
    return [job for same in records.values() for job in same]


def batch_shape(job: Job) -> object:
    """What jobs must share so that one task can compute them and one shard can contain them."""
    wavelet = job.analysis.wavelet
    time_axis = job.parameters.record.time_axis
    return time_axis, wavelet.levels, wavelet.phase == "all", job.stored is None


def _batch_size(n_job: int, n_sample: int, workers: int) -> int:
    largest = max(WIDTH, min(_LARGEST_BATCH, _MOST_SAMPLES // n_sample // WIDTH * WIDTH))
    if n_job <= workers * WIDTH:
        return max(1, -(-n_job // workers))
    even = -(-n_job // (workers * _BATCHES_PER_WORKER))
    return min(largest, -(-even // WIDTH) * WIDTH)


def run_batches(
    engine: Engine,
    batches: Iterable[Batch],
    time_per_job: float | None,
    on_done: Callable[[BatchReceipt], None],
    on_failure: Callable[[Job, TaskFailure], None],
) -> None:
    """Run batches; a batch that fails is halved until its failing jobs stand alone.

    Parameters
    ----------
    engine : Engine
    batches : iterable of Batch
    time_per_job : float or None
        Wall time that one run may take [s]. Runs of a batch that lie side by side in lanes share it.
    on_done : callable
        Receives news of each batch that is stored.
    on_failure : callable
        Receives news of each job that failed by itself.

    Raises
    ------
    HydrofdiError
        A task met an error that the user can fix, such as a full disk.
    """
    for batch in batches:
        engine.submit(compute_shard, batch, _time_limit(batch, time_per_job))
    for result in engine.completed():
        batch = result.item
        if result.failure is None:
            on_done(result.value)
        elif isinstance(result.failure.error, HydrofdiError):
            engine.cancel()
            raise result.failure.error
        elif len(batch.jobs) > 1:
            middle = len(batch.jobs) // 2
            for jobs in (batch.jobs[:middle], batch.jobs[middle:]):
                half = replace(batch, jobs=jobs)
                engine.submit(compute_shard, half, _time_limit(half, time_per_job))
        else:
            on_failure(batch.jobs[0], result.failure)


def _time_limit(batch: Batch, time_per_job: float | None) -> float | None:
    return None if time_per_job is None else time_per_job * -(-len(batch.jobs) // WIDTH)
