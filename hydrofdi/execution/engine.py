"""Engines: where tasks run. One small contract, several places."""

from __future__ import annotations

import traceback
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, Self


@dataclass(frozen=True)
class TaskFailure:
    """Why a task gave no result: ``error``, ``timeout`` or ``killed``, a sentence, and its traceback."""

    status: str
    message: str
    log: str = ""
    error: BaseException | None = None


@dataclass(frozen=True)
class TaskResult:
    """An item with the value that a task gave for it, or its failure."""

    item: Any
    value: Any = None
    failure: TaskFailure | None = None


class Engine(Protocol):
    """Runs tasks in its workers. Used as a context: leaving it ends the workers.

    A task that raises, hangs or loses its worker fails; the others continue.
    """

    workers: int
    """Number of tasks that run at a time."""

    reads_results: bool
    """Whether its workers reach the folder of the results."""

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task; `time_limit` is the wall time that it may take [s]."""
        ...

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        ...

    def cancel(self) -> None:
        """Forget what is queued; running tasks continue."""
        ...

    def __enter__(self) -> Self:
        """Start the workers."""
        ...

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """End the workers; after an error in the middle of what they do."""
        ...


class InProcessEngine:
    """Runs tasks here, one after the other; it cannot end one that takes too long."""

    workers = 1
    reads_results = True

    def __init__(self) -> None:
        self._queue: deque[tuple[Callable[[Any], Any], Any]] = deque()

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task; the time limit is not kept."""
        self._queue.append((task, item))

    def completed(self) -> Iterator[TaskResult]:
        """Results in the order of submission."""
        while self._queue:
            task, item = self._queue.popleft()
            try:
                value = task(item)
            except Exception as error:
                yield TaskResult(item, failure=raised(error))
            else:
                yield TaskResult(item, value)

    def cancel(self) -> None:
        """Forget what is queued."""
        self._queue.clear()

    def __enter__(self) -> Self:
        """Nothing to start."""
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """Nothing to end."""


def raised(error: BaseException) -> TaskFailure:
    """The failure of a task that raised."""
    text = str(error).splitlines()
    message = f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
    return TaskFailure("error", message, "".join(traceback.format_exception(error)), error)
