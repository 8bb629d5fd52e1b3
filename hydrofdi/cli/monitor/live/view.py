"""The live view of a stream on a terminal."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from rich.console import Console, ConsoleOptions, Group, RenderResult
from rich.live import Live

from hydrofdi.api.monitoring.lines import Line
from hydrofdi.cli.monitor.live.page import Page
from hydrofdi.cli.monitor.live.screen import screen_lines
from hydrofdi.cli.monitor.live.summary import summary_lines
from hydrofdi.cli.monitor.live.watched import Watched
from hydrofdi.detectors.trained import DetectorFile
from hydrofdi.records.streams import Chunk

_FRAMES_IN_A_SECOND = 4.0


class LiveView:
    """A sink that fills the terminal, and leaves a summary when it is closed.

    Parameters
    ----------
    file : DetectorFile
    source : str
        Name of the source.
    console : Console
        A terminal.
    """

    def __init__(self, file: DetectorFile, source: str, console: Console) -> None:
        self.watched = Watched(file, source)
        self._lock = threading.Lock()
        self._console = console
        self._live = Live(self, console=console, screen=True, refresh_per_second=_FRAMES_IN_A_SECOND)

    def put(self, chunk: Chunk | None, lines: Sequence[Line]) -> Sequence[Line]:
        """Take samples and lines; the screen is updated a few times a second."""
        with self._lock:
            self.watched.take(chunk, lines)
        if not self._live.is_started:
            self._live.start(refresh=True)
        return ()

    def close(self) -> None:
        """Restore the terminal, and print the summary."""
        if not self._live.is_started:
            return
        self._live.stop()
        for line in summary_lines(self.watched):
            self._console.print(line, soft_wrap=True, markup=False, highlight=False)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """The present screen."""
        page = Page(console.width, console.height, options.ascii_only)
        with self._lock:
            lines = screen_lines(self.watched, page)
        yield Group(*lines)
