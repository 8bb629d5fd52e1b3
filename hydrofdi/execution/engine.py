"""Engines: where tasks run. One small contract, several places."""

from __future__ import annotations

import traceback
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Self


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


@dataclass(frozen=True)
class Task:
    """A function, what it is called with, and the wall time that workers elsewhere give it [s]."""

    function: Callable[[Any], Any]
    item: Any
    time_limit: float | None


class Engine:
    """Runs tasks here, one after the other; the engines that derive from it have workers elsewhere.

    Used as a context: leaving it ends the workers. A task that raises, hangs or loses its worker fails; the
    others continue.
    """

    workers = 1
    """Number of tasks that run at a time."""

    reads_results = True
    """Whether its workers reach the folder of the results."""

    lost_workers = 0
    """Number of workers that were killed and replaced, as far as the engine learns of them."""

    def __init__(self) -> None:
        self._queue: deque[Task] = deque()

    def submit(self, task: Callable[[Any], Any], item: Any, time_limit: float | None = None) -> None:
        """Queue a task; workers elsewhere end it when it runs longer than the limit [s]."""
        self._queue.append(Task(task, item, time_limit))

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        while self._queue:
            task = self._queue.popleft()
            try:
                value = task.function(task.item)
            except Exception as error:
                yield TaskResult(task.item, failure=raised(error))
            else:
                yield TaskResult(task.item, value)

    def cancel(self) -> None:
        """Forget what is queued; running tasks continue."""
        self._queue.clear()

    def __enter__(self) -> Self:
        """Start the workers."""
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """End the workers; after an error in the middle of what they do."""


InProcessEngine = Engine


def raised(error: BaseException) -> TaskFailure:
    """The failure of a task that raised."""
    text = str(error).splitlines()
    message = f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
    return TaskFailure("error", message, "".join(traceback.format_exception(error)), error)
