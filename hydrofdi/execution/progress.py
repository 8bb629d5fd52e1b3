"""The progress of a sweep: a line on a terminal and in a notebook, a line now and then elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from shutil import get_terminal_size

from hydrofdi.settings.arguments import refusal
from hydrofdi.settings.messages import time_text

_SECONDS_BETWEEN_DRAWINGS, _SECONDS_BETWEEN_LINES = 0.5, 30.0
_BAR = 20

RUNS, COEFFICIENTS = "runs", "leakage coefficients K_i solved before the runs"


class Watching:
    """Progress and messages of a sweep on standard error, if they are shown, from the first second on."""

    def __init__(self, *, is_shown: bool = False) -> None:
        self._is_shown = is_shown
        self._redraws = sys.stderr.isatty() or "ipykernel" in sys.modules
        self._what, self._total, self._done, self._n_failed, self._start = "", 0, 0, 0, time.monotonic()
        self._n_drawn = 0
        self.ended = threading.Event()
        self._lock = threading.RLock()

    def __str__(self) -> str:
        seconds = time.monotonic() - self._start
        counted = f"{self._done:,} of {self._total:,} {self._what}"
        if not self._done:
            return f"{counted}, {time_text(seconds)} so far"
        rate, left = self._done / max(seconds, 1e-9), (self._total - self._done) * seconds / self._done
        speed = f"{rate:,.0f}/s" if rate >= 9.5 else f"{rate:.2g}/s"
        return f"{counted}, {speed}, {self._n_failed:,} failed, {time_text(left)} left"

    def begin(self, what: str, total: int) -> None:
        """State the number of `what` that are to be computed."""
        self._what, self._total, self._done, self._n_failed = what, total, 0, 0
        self._start = time.monotonic()
        self._draw()

    def advance(self, count: int, n_failed: int = 0) -> None:
        """Count more that ended, and how many of these failed."""
        self._done, self._n_failed = self._done + count, self._n_failed + n_failed
        self._draw()

    def tell(self, message: object) -> None:
        """Print a line above the progress."""
        if self._is_shown:
            with self._lock:
                self.erase()
                print(message, file=sys.stderr, flush=True)

    def repeat(self) -> None:
        """Refresh the progress regularly, so that a long run does not look like a standstill."""
        while not self.ended.wait(_SECONDS_BETWEEN_DRAWINGS if self._redraws else _SECONDS_BETWEEN_LINES):
            if self._total:
                self._draw() if self._redraws else self.tell(self)

    def _draw(self) -> None:
        if not (self._is_shown and self._redraws):
            return
        filled = _BAR * self._done // max(self._total, 1)
        line = f"[{'#' * filled}{'.' * (_BAR - filled)}] {self}"[: get_terminal_size().columns - 1]
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
def watching(progress: bool) -> Iterator[Watching]:
    """The watcher that a caller chose."""
    if not isinstance(progress, bool):
        raise refusal("progress", "True or False", progress)
    watcher = Watching(is_shown=progress)
    if progress:
        threading.Thread(target=watcher.repeat, daemon=True).start()
    try:
        yield watcher
    finally:
        watcher.ended.set()
        watcher.erase()
