"""A pool of processes on this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from multiprocessing.connection import wait
from types import TracebackType
from typing import Any, Self

from pebble import ProcessPool

from hydrofdi.execution.engine import Item, Result

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalPoolEngine:
    """Worker processes that are forked from a server which has loaded the simulation once.

    Parameters
    ----------
    workers : int
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pool: Any = None

    def __enter__(self) -> Self:
        """Start the workers."""
        for variable in _THREAD_VARIABLES:
            os.environ.setdefault(variable, "1")
        if "forkserver" in multiprocessing.get_all_start_methods():
            context: Any = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload(["hydrofdi.execution.compute"])
        else:
            context = multiprocessing.get_context("spawn")
        self._pool = ProcessPool(max_workers=self._workers, initializer=_start_worker, context=context)
        return self

    def results(self, task: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """The result of `task` for every item, as they come."""
        futures = [self._pool.schedule(task, args=(item,)) for item in items]
        for future in as_completed(futures):
            yield future.result()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """End the workers; after an error, in the middle of what they do."""
        if error is None:
            self._pool.close()
        else:
            self._pool.stop()
        self._pool.join()


def _start_worker() -> None:
    """Leave Ctrl-C to the parent, and die when it dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()


def _die_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
