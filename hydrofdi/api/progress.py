"""The progress of a sweep: a line on a terminal and in a notebook, a line now and then elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from shutil import get_terminal_size

from hydrofdi.api.arguments import refusal
from hydrofdi.settings.readable import time_text

_SECONDS_BETWEEN_DRAWINGS, _SECONDS_BETWEEN_LINES = 0.5, 30.0
_BAR = 20

RUNS, COEFFICIENTS = "runs", "leakage coefficients K_i solved before the runs"


@dataclass(frozen=True)
class Progress:
    """Progress of a sweep: how many of ``what`` have ended of the ``total``, and how many ``failed``, since
    so many ``seconds``.

    Examples
    --------
    >>> print(Progress("runs", done=640, total=1460, failed=0, seconds=16.0))
    640 of 1,460 runs, 40/s, 0 failed, 20.5 s left
    """

    what: str
    done: int
    total: int
    failed: int
    seconds: float

    @property
    def seconds_left(self) -> float | None:
        """Remaining time at the mean rate [s]; None before anything ended."""
        return (self.total - self.done) * self.seconds / self.done if self.done else None

    def __str__(self) -> str:
        counted = f"{self.done:,} of {self.total:,} {self.what}"
        if not self.done or self.seconds_left is None:
            return f"{counted}, {time_text(self.seconds)} so far"
        rate = self.done / max(self.seconds, 1e-9)
        speed = f"{rate:,.0f}/s" if rate >= 9.5 else f"{rate:.2g}/s"
        return f"{counted}, {speed}, {self.failed:,} failed, {time_text(self.seconds_left)} left"


class Watching:
    """A watcher that calls a function with each `Progress`."""

    def __init__(self, show: Callable[[Progress], object]) -> None:
        self._show = show
        self._counts, self._start = Progress("", 0, 0, 0, 0.0), time.monotonic()

    @property
    def progress(self) -> Progress:
        """Present progress of the sweep."""
        return replace(self._counts, seconds=time.monotonic() - self._start)

    def begin(self, what: str, total: int) -> None:
        """State the number of `what` that are to be computed."""
        self._counts, self._start = Progress(what, 0, total, 0, 0.0), time.monotonic()
        self._show(self.progress)

    def advance(self, count: int, n_failed: int = 0) -> None:
        """Count more that ended, and how many of these failed."""
        counts = self._counts
        self._counts = replace(counts, done=counts.done + count, failed=counts.failed + n_failed)
        self._show(self.progress)

    def tell(self, message: object) -> None:
        """Does nothing: messages are for people."""


class StandardError(Watching):
    """Progress and messages on standard error, from the first second on."""

    def __init__(self) -> None:
        self._redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._n_drawn = 0
        self.ended = threading.Event()
        self._lock = threading.RLock()
        super().__init__(self._draw if self._redraws else lambda _: None)

    def tell(self, message: object) -> None:
        """Print a line above the progress."""
        with self._lock:
            self.erase()
            print(message, file=sys.stderr, flush=True)

    def repeat(self) -> None:
        """Refresh the progress regularly, so that a long run does not look like a standstill."""
        while not self.ended.wait(_SECONDS_BETWEEN_DRAWINGS if self._redraws else _SECONDS_BETWEEN_LINES):
            if self._counts.total:
                (self._draw if self._redraws else self.tell)(self.progress)

    def _draw(self, progress: Progress) -> None:
        filled = _BAR * progress.done // max(progress.total, 1)
        line = f"[{'#' * filled}{'.' * (_BAR - filled)}] {progress}"[: get_terminal_size().columns - 1]
        with self._lock:
            if not self.ended.is_set():
                sys.stderr.write("\r" + line.ljust(self._n_drawn))
                sys.stderr.flush()
                self._n_drawn = len(line)

    def erase(self) -> None:
        """Remove the progress line."""
        with self._lock:
            if self._n_drawn:
                sys.stderr.write("\r" + " " * self._n_drawn + "\r")
                sys.stderr.flush()
                self._n_drawn = 0


@contextmanager
def watching(progress: bool | Callable[[Progress], object]) -> Iterator[Watching]:
    """The watcher that a caller chose."""
    if not callable(progress) and not isinstance(progress, bool):
        raise refusal("progress", "True, False or a function", progress)
    if progress is not True:
        yield Watching(progress or (lambda _: None))
        return
    watcher = StandardError()
    threading.Thread(target=watcher.repeat, daemon=True).start()
    try:
        yield watcher
    finally:
        watcher.ended.set()
        watcher.erase()
