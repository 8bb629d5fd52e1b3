"""An engine on a Dask cluster, for many machines."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

from hydrofdi.errors import ConfigError
from hydrofdi.execution.compute import Batch, BatchReceipt, compute_shard
from hydrofdi.execution.engine import Engine, TaskFailure, TaskResult, raised
from hydrofdi.store.shard import store_shard_bytes

PATIENCE = "10s"
"""How long a scheduler may take to answer."""


class DaskEngine(Engine):
    """Tasks on the workers of a Dask scheduler; tasks of a worker that is lost are computed by another."""

    def __init__(self, scheduler: str, *, shared_directory: bool = True) -> None:
        try:
            import distributed
        except ImportError:
            raise ConfigError("the engine dask needs the extra: pip install 'hydrofdi[dask]'") from None
        self._distributed: Any = distributed
        self._scheduler = scheduler
        self._shared_directory = self.reads_results = shared_directory
        self._client: Any = None
        self._completed: Any = None
        self._items: dict[str, Any] = {}

    def __enter__(self) -> Self:
        """Connect to the scheduler."""
        try:
            self._client = self._distributed.Client(self._scheduler, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise ConfigError(f"{self._named()}: no answer ({type(error).__name__})") from None
        self.workers = sum(self._client.nthreads().values())
        if self.workers == 0:
            self._client.close()
            raise ConfigError(f"{self._named()}: the cluster has no workers")
        self._completed = self._distributed.as_completed(loop=self._client.loop)
        return self

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task. Dask cannot end a running task; a limit belongs to the cluster's job then."""
        work = task if self._shared_directory or task is not compute_shard else _compute_and_send
        if isinstance(item, Batch) and self._shared_directory:
            item = replace(item, directory=item.directory.resolve())
        future = self._client.submit(work, item, pure=False)
        self._items[future.key] = item
        self._completed.add(future)

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        while self._items:
            future = next(self._completed)
            item = self._items.pop(future.key, None)
            if item is not None and not future.cancelled():
                yield self._result(item, future)

    def cancel(self) -> None:
        """Forget what is queued; running tasks continue."""
        running = {key for keys in self._client.processing().values() for key in keys}
        queued = [key for key in self._items if key not in running]
        for key in queued:
            self._items.pop(key)
        self._client.cancel([self._distributed.Future(key, self._client) for key in queued], force=True)

    def _named(self) -> str:
        return f"scheduler={self._scheduler}"

    def _result(self, item: Any, future: Any) -> TaskResult:
        try:
            value = future.result()
        except self._distributed.KilledWorker as error:
            return TaskResult(item, failure=TaskFailure("killed", str(error).splitlines()[0], error=error))
        except Exception as error:
            return TaskResult(item, failure=raised(error))
        if isinstance(value, tuple) and value and isinstance(value[0], BatchReceipt):
            receipt, content = value
            value = replace(receipt, shard=store_shard_bytes(item.directory, content))
        return TaskResult(item, value)

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """Leave the cluster; after an error forget what it still does for us."""
        if error is not None:
            self._client.cancel(
                [self._distributed.Future(key, self._client) for key in self._items], force=True
            )
        self._client.close()


def _compute_and_send(batch: Batch) -> tuple[BatchReceipt, bytes]:
    """Compute a shard in a folder of the worker's own, and return its content."""
    with tempfile.TemporaryDirectory(prefix="hydrofdi-") as folder:
        receipt = compute_shard(replace(batch, directory=Path(folder)))
        return receipt, receipt.shard.read_bytes()
