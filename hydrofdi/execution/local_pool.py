"""A pool of processes on this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from multiprocessing.connection import wait as wait_for_sentinels
from types import TracebackType
from typing import Any, Self

from pebble import ProcessExpired, ProcessPool

from hydrofdi.execution.engine import TaskFailure, TaskResult, raised

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalPoolEngine:
    """Worker processes, forked from a server that has loaded the simulation once.

    Parameters
    ----------
    workers : int
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool: Any = None
        self._queue: deque[tuple[Callable[[Any], Any], Any, float | None]] = deque()
        self._running: dict[Future[Any], tuple[Any, float | None]] = {}

    def __enter__(self) -> Self:
        """Start the workers."""
        for variable in _THREAD_VARIABLES:
            os.environ.setdefault(variable, "1")
        if "forkserver" in multiprocessing.get_all_start_methods():
            context: Any = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload(["hydrofdi.execution.compute"])
        else:
            context = multiprocessing.get_context("spawn")
        self._pool = ProcessPool(max_workers=self.workers, initializer=_start_worker, context=context)
        return self

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task; it is ended and fails when it runs longer than the limit [s]."""
        self._queue.append((task, item, time_limit))

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        while self._queue or self._running:
            self._feed()
            done, _ = wait(self._running, return_when=FIRST_COMPLETED)
            for future in done:
                item, time_limit = self._running.pop(future)
                yield _result(item, time_limit, future)

    def cancel(self) -> None:
        """Forget what is queued; what runs goes on."""
        self._queue.clear()

    def _feed(self) -> None:
        """Keep every worker busy, and no more, so that little is lost when all stops."""
        while self._queue and len(self._running) < self.workers:
            task, item, time_limit = self._queue.popleft()
            future = self._pool.schedule(task, args=(item,), timeout=time_limit)
            self._running[future] = item, time_limit

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the workers; after an error in the middle of what they do."""
        if error is None:
            self._pool.close()
        else:
            self._pool.stop()
        self._pool.join()


def _result(item: Any, time_limit: float | None, future: Future[Any]) -> TaskResult:
    try:
        return TaskResult(item, future.result())
    except TimeoutError as error:
        message = f"ended after the limit of {time_limit:g} s" if time_limit else str(error)
        return TaskResult(item, failure=TaskFailure("timeout", message, error=error))
    except ProcessExpired as error:
        message = f"its worker process ended with code {error.exitcode}"
        return TaskResult(item, failure=TaskFailure("killed", message, error=error))
    except Exception as error:
        return TaskResult(item, failure=raised(error))


def _start_worker() -> None:
    """Leave Ctrl-C to the parent, and die when it dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()


def _die_with(sentinel: int) -> None:
    wait_for_sentinels([sentinel])
    os._exit(1)
