"""Engines by their names, and the one on a Dask cluster, for many machines."""

from __future__ import annotations

import asyncio
import logging
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Self

from hydrofdi.engine import (
    Engine,
    InProcessEngine,
    LocalPoolEngine,
    TaskFailure,
    TaskResult,
    available_cores,
    raised,
)
from hydrofdi.errors import ConfigError, HydrofdiError
from hydrofdi.execution.compute import Batch, BatchReceipt, compute_shard
from hydrofdi.settings.messages import nearest
from hydrofdi.store.shards import store_shard_bytes


def engine_named(
    name: str, workers: int | None, scheduler: str | None, *, shared_directory: bool = True
) -> Engine:
    """An engine by its name; `workers` of a local pool are by default the cores that this process may use."""
    if name not in (known := ("local", "in-process", "dask")):
        raise ConfigError(f"engine: {name!r} is unknown{nearest(str(name), known)}")
    if name == "dask":
        if not isinstance(scheduler, str):
            raise ConfigError("the engine dask needs scheduler=tcp://host:port")
        return DaskEngine(scheduler, shared_directory=shared_directory)
    if scheduler is not None or not shared_directory:
        raise ConfigError("scheduler and shared_directory need engine=dask")
    return InProcessEngine() if name == "in-process" else LocalPoolEngine(workers or available_cores())


PATIENCE = "10s"
"""How long a scheduler may take to answer the first time."""

MOST_SECONDS_WITHOUT_WORKERS = 720.0
"""A cluster that has no worker for so long has ended. Dask gives up a silent worker after 5 to 10 minutes."""

_SECONDS_BETWEEN_LOOKS = 2.0


class DaskEngine(Engine):
    """Tasks on the workers of a Dask scheduler; tasks of a worker that is lost are computed by another."""

    def __init__(self, scheduler: str, *, shared_directory: bool = True) -> None:
        try:
            import distributed
        except ImportError:
            raise ConfigError("the engine dask needs the extra: pip install 'hydrofdi[dask]'") from None
        self._distributed: Any = distributed
        self._scheduler, self._name = scheduler, f"scheduler={scheduler}"
        self._shared_directory = self.reads_results = shared_directory
        self._client: Any = None
        self._items: dict[Any, Any] = {}
        self._ended: SimpleQueue[Any] = SimpleQueue()

    def __enter__(self) -> Self:
        """Connect to the scheduler."""
        try:
            self._client = self._distributed.Client(self._scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise ConfigError(f"{self._name}: no answer ({type(error).__name__})") from None
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # our errors say it in a line
        self._client.loop.asyncio_loop.set_exception_handler(lambda *_: None)
        self.workers = sum(self._client.nthreads().values())
        if self.workers == 0:
            self._client.close()
            raise ConfigError(f"{self._name}: the cluster has no workers")
        return self

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task. Dask cannot end a running task; a limit belongs to the cluster's job then."""
        work = task if self._shared_directory or task is not compute_shard else _compute_and_send
        if isinstance(item, Batch) and self._shared_directory:
            item = replace(item, directory=item.directory.resolve())
        if self._client.status != "running":
            raise self._lost()
        future = self._client.submit(work, item, pure=False)
        self._items[future] = item
        future.add_done_callback(self._ended.put)

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        while self._items:
            future = self._next()
            if future in self._items:
                yield self._result(self._items.pop(future), future)

    def cancel(self) -> None:
        """Forget what is queued; running tasks continue."""
        running = {key for keys in self._ask("processing").values() for key in keys}
        queued = [future for future in self._items if future.key not in running]
        for future in queued:
            self._items.pop(future)
        self._client.cancel(queued, force=True)

    def _next(self) -> Any:
        """The next future that has ended, as long as there are workers."""
        alive = time.monotonic()
        while time.monotonic() - alive < MOST_SECONDS_WITHOUT_WORKERS:
            with suppress(Empty):
                return self._ended.get(timeout=_SECONDS_BETWEEN_LOOKS)
            if self._ask("ncores"):
                alive = time.monotonic()
        raise self._lost()

    def _ask(self, question: str) -> Any:
        """What the scheduler answers."""
        ask = getattr(self._client.scheduler, question)
        try:
            return self._client.sync(ask, callback_timeout=MOST_SECONDS_WITHOUT_WORKERS)
        except Exception:
            raise self._lost() from None

    def _lost(self) -> HydrofdiError:
        return HydrofdiError(f"{self._name}: the cluster has ended")

    def _result(self, item: Any, future: Any) -> TaskResult:
        try:
            value = future.result(MOST_SECONDS_WITHOUT_WORKERS)
        except (Exception, asyncio.CancelledError) as error:
            if future.status != "error":
                raise self._lost() from None
            if isinstance(error, self._distributed.KilledWorker):
                message = str(error).splitlines()[0]
                return TaskResult(item, failure=TaskFailure("killed", message, error=error))
            return TaskResult(item, failure=raised(error))
        if isinstance(value, tuple) and value and isinstance(value[0], BatchReceipt):
            receipt, content = value
            value = replace(receipt, shard=store_shard_bytes(item.directory, content))
        return TaskResult(item, value)

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """Leave the cluster, which forgets what it still does for us."""
        self._client.close()


def _compute_and_send(batch: Batch) -> tuple[BatchReceipt, bytes]:
    """Compute a shard in a folder of the worker's own, and return its content."""
    with tempfile.TemporaryDirectory(prefix="hydrofdi-") as folder:
        receipt = compute_shard(replace(batch, directory=Path(folder)))
        return receipt, receipt.shard.read_bytes()
