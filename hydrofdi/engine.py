"""Engines: where tasks run. One small contract; this process, or a pool of processes.

Each process has its own pipe: they share no lock that one could take with it if it is killed."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from multiprocessing import forkserver, resource_tracker
from multiprocessing.connection import Connection, wait
from types import ModuleType
from typing import Any, Self

from hydrofdi.errors import HydrofdiError


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


TIME_LIMIT: ContextVar[float | None] = ContextVar("wall time of a run [s]", default=None)
"""Wall time of a run that needs a process of its own outside a sweep, which limits its tasks itself."""


@contextmanager
def limited(seconds: float | None) -> Iterator[None]:
    """Limit the wall time of such runs within."""
    token = TIME_LIMIT.set(seconds)
    try:
        yield
    finally:
        TIME_LIMIT.reset(token)


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


def run_halving(
    engine: Engine,
    task: Callable[[Any], Any],
    items: Iterable[Any],
    split: Callable[[Any], Sequence[Any]],
    time_limit: Callable[[Any], float | None],
) -> Iterator[TaskResult]:
    """Results of items as they come; an item that fails is halved until what fails stands alone.

    An error of the user, such as a full disk, ends all.
    """
    for item in items:
        engine.submit(task, item, time_limit(item))
    for result in engine.completed():
        if result.failure and isinstance(result.failure.error, HydrofdiError):
            engine.cancel()
            raise result.failure.error
        parts = split(result.item) if result.failure else ()
        for part in parts:
            engine.submit(task, part, time_limit(part))
        if not parts:
            yield result


def halves(items: Sequence[Any]) -> list[Sequence[Any]]:
    """Two halves of some items; none of a single one."""
    middle = len(items) // 2
    return [items[:middle], items[middle:]] if middle else []


def raised(error: BaseException) -> TaskFailure:
    """The failure of a task that raised."""
    text = str(error).splitlines()
    message = f"{type(error).__name__}: {text[0]}" if text else type(error).__name__
    return TaskFailure("error", message, "".join(traceback.format_exception(error)), error)


_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_SECONDS_TO_END = 2.0


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Worker:
    """A process that computes one task after the other."""

    def __init__(self, context: Any) -> None:
        self.pipe, other = multiprocessing.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        with _without_interrupts(), _without_main():
            self.process.start()
        other.close()
        self.task: Task | None = None
        self._deadline = float("inf")

    def begin(self, task: Task) -> None:
        """Hand a task over."""
        self.task = task
        self._deadline = float("inf") if task.time_limit is None else time.monotonic() + task.time_limit
        self.pipe.send((task.function, task.item))

    def seconds_left(self) -> float:
        """Until the time limit of the task."""
        return self._deadline - time.monotonic()

    def end_task(self) -> TaskResult:
        """The result of a task that has ended, one way or another."""
        assert self.task is not None
        item, self.task = self.task.item, None
        try:
            value, failure = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            message = f"its worker process ended with code {self.process.exitcode}"
            return TaskResult(item, failure=TaskFailure("killed", message))
        return TaskResult(item, value, failure)

    def time_out(self) -> TaskResult:
        """Kill the process in the middle of its task."""
        assert self.task is not None
        item, limit, self.task = self.task.item, self.task.time_limit, None
        self.kill()
        return TaskResult(item, failure=TaskFailure("timeout", f"ended after the limit of {limit:g} s"))

    def kill(self) -> None:
        """End the process at once."""
        self.process.kill()
        self.process.join()
        self.pipe.close()

    def dismiss(self) -> None:
        """Let an idle process end."""
        self.pipe.close()
        self.process.join(_SECONDS_TO_END)
        if self.process.is_alive():
            self.process.kill()


@contextmanager
def _without_main() -> Iterator[None]:
    """Hide the main module from new processes, which would run a script again that started them."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Hold Ctrl-C back; what starts meanwhile never sees it, and this process sees it afterwards."""
    usual, held = signal.getsignal(signal.SIGINT), list[Any]()
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    if is_main:
        # The mask is this thread's: with another thread, Python would still call the handler here.
        signal.signal(signal.SIGINT, lambda *given: held.append(given))
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, usual)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if held and callable(usual):
            usual(*held[-1])


class LocalPoolEngine(Engine):
    """Worker processes, forked from a server that has loaded the simulation once."""

    def __init__(self, workers: int) -> None:
        super().__init__()
        self.workers = workers
        self._context: Any = None
        self._crew: list[_Worker] = []

    def __enter__(self) -> Self:
        """Start the server that workers are forked from."""
        for variable in _THREAD_VARIABLES:
            os.environ.setdefault(variable, "1")
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(["hydrofdi.execution.compute"])
        resource_tracker.ensure_running()  # lets signals through when it has started
        with _without_interrupts(), _without_main():
            forkserver.ensure_running()
        return self

    def completed(self) -> Iterator[TaskResult]:
        """Results as they come, until nothing is queued or running."""
        while self._queue or self._busy():
            self._feed()
            busy = self._busy()
            if not busy:  # cancelled meanwhile, or the idle workers died
                continue
            patience = max(0.0, min(worker.seconds_left() for worker in busy))
            ready = wait([worker.pipe for worker in busy], None if patience == float("inf") else patience)
            for worker in busy:
                if worker.pipe in ready:
                    yield worker.end_task()
                elif worker.seconds_left() <= 0.0:
                    self._crew.remove(worker)
                    yield worker.time_out()

    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._crew if worker.task is not None]

    def _feed(self) -> None:
        """Give every worker one task, and no more, so that little is lost when all stops."""
        living = [worker for worker in self._crew if worker.task is not None or worker.process.is_alive()]
        self.lost_workers += len(self._crew) - len(living)
        self._crew = living
        while len(self._crew) < min(self.workers, len(self._queue) + len(self._busy())):
            self._crew.append(_Worker(self._context))
        for worker in self._crew:
            if worker.task is None and (task := self._next_task()) is not None:
                try:
                    worker.begin(task)
                except OSError:  # killed while it was idle
                    worker.task = None
                    self._queue.appendleft(task)

    def _next_task(self) -> Task | None:
        """Take a task from the queue, which a signal handler may empty at any moment."""
        try:
            return self._queue.popleft()
        except IndexError:
            return None

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        """End the workers; after an error in the middle of what they do."""
        for worker in self._crew:
            if error is None and worker.task is None:
                worker.dismiss()
            else:
                worker.kill()


def _serve(pipe: Connection) -> None:
    """Compute what comes through a pipe until it is closed. The body of a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()
    while True:
        try:
            function, item = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer: tuple[Any, TaskFailure | None] = function(item), None
        except Exception as error:
            answer = None, _picklable(raised(error))
        pipe.send(answer)


def _picklable(failure: TaskFailure) -> TaskFailure:
    try:
        pickle.loads(pickle.dumps(failure))
    except Exception:
        return replace(failure, error=None)
    return failure


def _die_with(sentinel: int) -> None:
    """End this process as soon as its parent is gone."""
    wait([sentinel])
    os._exit(1)
