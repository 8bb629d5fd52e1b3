"""Batches through an engine; a batch that fails is halved until the run is found that fails."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from hydrofdi.errors import HydrofdiError
from hydrofdi.execution.compute import Batch, BatchReceipt, compute_shard
from hydrofdi.execution.engine import Engine, TaskFailure
from hydrofdi.execution.jobs import Job
from hydrofdi.simulation.kernels.lanes import WIDTH


@dataclass(frozen=True)
class JobFailure:
    """A job that gave no result, and why."""

    job: Job
    failure: TaskFailure


def run_batches(
    engine: Engine,
    batches: Iterable[Batch],
    time_per_job: float | None,
    on_done: Callable[[BatchReceipt], None],
    on_failure: Callable[[JobFailure], None],
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
            for half in _halves(batch):
                engine.submit(compute_shard, half, _time_limit(half, time_per_job))
        else:
            on_failure(JobFailure(batch.jobs[0], result.failure))


def _halves(batch: Batch) -> tuple[Batch, Batch]:
    middle = len(batch.jobs) // 2
    return replace(batch, jobs=batch.jobs[:middle]), replace(batch, jobs=batch.jobs[middle:])


def _time_limit(batch: Batch, time_per_job: float | None) -> float | None:
    return None if time_per_job is None else time_per_job * -(-len(batch.jobs) // WIDTH)
