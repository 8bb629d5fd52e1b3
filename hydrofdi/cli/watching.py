"""The progress of a sweep on standard error: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType
from typing import Any, Self

from hydrofdi.cli.terminal import tell

_SECONDS_BETWEEN_LINES = 30.0


class SweepWatcher:
    """Shows how a sweep goes on. Used as a context."""

    def __init__(self) -> None:
        self._n_run = self._n_done = self._n_failed = 0
        self._start = time.monotonic()
        self._bar: Any = None
        self._task: Any = None
        self._ended = threading.Event()

    def __enter__(self) -> Self:
        """Nothing to show yet."""
        return self

    def begin(self, n_run: int) -> None:
        """Show that so many runs are to be computed."""
        self._n_run, self._start = n_run, time.monotonic()
        if n_run == 0:
            return
        if sys.stderr.isatty():
            self._start_bar()
        else:
            threading.Thread(target=self._print_lines, daemon=True).start()

    def advance(self, n_run: int, n_failed: int) -> None:
        """Show that so many more runs ended, and so many of them failed."""
        self._n_done += n_run
        self._n_failed += n_failed
        if self._bar is not None:
            self._bar.update(
                self._task, advance=n_run, failed=self._n_failed, rate=self._rate(), left=self._left()
            )

    def tell(self, message: str) -> None:
        """Show a line."""
        if self._bar is not None:
            self._bar.console.print(message, markup=False, highlight=False)
        else:
            tell(message)

    def _rate(self) -> float:
        return self._n_done / max(time.monotonic() - self._start, 1e-9)

    def _left(self) -> str:
        """Time left at the mean rate."""
        if not self._n_done:
            return "?"
        seconds = round((self._n_run - self._n_done) / self._rate())
        return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"

    def _start_bar(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        self._bar = Progress(
            TextColumn("sweep"), BarColumn(), MofNCompleteColumn(),
            TextColumn("runs, {task.fields[rate]:.0f}/s, {task.fields[failed]} failed,"),
            TextColumn("{task.fields[left]} left"), console=Console(stderr=True), transient=True,
        )  # fmt: skip
        self._task = self._bar.add_task("sweep", total=self._n_run, failed=0, rate=0.0, left="?")
        self._bar.start()

    def _print_lines(self) -> None:
        while not self._ended.wait(_SECONDS_BETWEEN_LINES):
            tell(
                f"{self._n_done} of {self._n_run} runs, {self._rate():.0f}/s,"
                f" {self._n_failed} failed, {self._left()} left"
            )

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Take the bar away."""
        self._ended.set()
        if self._bar is not None:
            self._bar.stop()
