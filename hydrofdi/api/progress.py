"""The progress of a sweep: a line on a terminal and in a notebook, a line now and then elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from shutil import get_terminal_size
from types import TracebackType
from typing import Self

from hydrofdi.api.arguments import refusal
from hydrofdi.settings.readable import shown_seconds

_SECONDS_BETWEEN_DRAWINGS, _SECONDS_BETWEEN_LINES = 0.5, 30.0
_BAR = 20

RUNS, COEFFICIENTS = "runs", "leakage coefficients K_i solved before the runs"


@dataclass(frozen=True)
class Progress:
    """Progress of a sweep.

    Attributes
    ----------
    what : str
        ``runs``, or ``leakage coefficients K_i solved before the runs``.
    done, total, failed : int
        Number of these that have ended, that are to be computed, and that failed.
    seconds : float
        Time since the first began [s].

    Examples
    --------
    >>> print(Progress("runs", done=640, total=1460, failed=0, seconds=16.0))
    640 of 1,460 runs, 40/s, 0 failed, 20 s left
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
            return f"{counted}, {shown_seconds(self.seconds)} so far"
        rate = self.done / max(self.seconds, 1e-9)
        speed = f"{rate:,.0f}/s" if rate >= 9.5 else f"{rate:.2g}/s"
        return f"{counted}, {speed}, {self.failed:,} failed, {shown_seconds(self.seconds_left)} left"


class Watching:
    """A watcher that calls a function with each `Progress`; used as a context, as all watchers are."""

    def __init__(self, show: Callable[[Progress], object]) -> None:
        self._show = show
        self._what, self._done, self._total, self._failed = "", 0, 0, 0
        self._start = time.monotonic()

    @property
    def progress(self) -> Progress:
        """Present progress of the sweep."""
        seconds = time.monotonic() - self._start
        return Progress(self._what, self._done, self._total, self._failed, seconds)

    def begin(self, what: str, total: int) -> None:
        """State the number of `what` that are to be computed."""
        self._what, self._done, self._total, self._failed = what, 0, total, 0
        self._start = time.monotonic()
        self._show(self.progress)

    def advance(self, count: int, n_failed: int = 0) -> None:
        """Count more that ended, and how many of these failed."""
        self._done += count
        self._failed += n_failed
        self._show(self.progress)

    def tell(self, message: str) -> None:
        """Does nothing: messages are for people."""

    def __enter__(self) -> Self:
        """Does nothing."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Does nothing."""


class StandardError(Watching):
    """Progress and messages on standard error, from the first second on."""

    def __init__(self) -> None:
        self._redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._drawn = ""
        self._ended = threading.Event()
        self._lock = threading.RLock()
        super().__init__(self._draw if self._redraws else lambda _: None)

    def tell(self, message: str) -> None:
        """Print a line above the progress."""
        with self._lock:
            self._erase()
            print(message, file=sys.stderr, flush=True)

    def __enter__(self) -> Self:
        """Refresh the progress regularly, so that a long run does not look like a standstill."""
        threading.Thread(target=self._repeat, daemon=True).start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Remove the progress line."""
        self._ended.set()
        with self._lock:
            self._erase()

    def _repeat(self) -> None:
        while not self._ended.wait(_SECONDS_BETWEEN_DRAWINGS if self._redraws else _SECONDS_BETWEEN_LINES):
            if self._total and self._redraws:
                self._draw(self.progress)
            elif self._total:
                self.tell(str(self.progress))

    def _draw(self, progress: Progress) -> None:
        filled = _BAR * progress.done // max(progress.total, 1)
        line = f"[{'#' * filled}{'.' * (_BAR - filled)}] {progress}"[: get_terminal_size().columns - 1]
        with self._lock:
            if not self._ended.is_set():
                sys.stderr.write("\r" + line.ljust(len(self._drawn)))
                sys.stderr.flush()
                self._drawn = line

    def _erase(self) -> None:
        if self._drawn:
            sys.stderr.write("\r" + " " * len(self._drawn) + "\r")
            sys.stderr.flush()
            self._drawn = ""


def watching(progress: bool | Callable[[Progress], object]) -> Watching:
    """The watcher that a caller chose.

    Raises
    ------
    ConfigError
        The value is neither a boolean nor a function.
    """
    if callable(progress):
        return Watching(progress)
    if not isinstance(progress, bool):
        raise refusal("progress", "True, False or a function", progress)
    return StandardError() if progress else Watching(lambda _: None)
