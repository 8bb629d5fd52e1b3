"""Ctrl-C and SIGTERM during a sweep."""

from __future__ import annotations

import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self


class Interruption:
    """Within this context the first Ctrl-C asks to finish, the second one and SIGTERM stop at once.

    Parameters
    ----------
    on_request : callable
        Is called at the first Ctrl-C.

    Attributes
    ----------
    requested : bool
        Whether there was one.
    """

    def __init__(self, on_request: Callable[[], None]) -> None:
        self.requested = False
        self._on_request = on_request
        self._previous: dict[int, Any] = {}

    def __enter__(self) -> Self:
        """Take over both signals."""
        for number in (signal.SIGINT, signal.SIGTERM):
            self._previous[number] = signal.signal(number, self._handle)
        return self

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if number == signal.SIGTERM or self.requested:
            raise KeyboardInterrupt
        self.requested = True
        self._on_request()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Give both signals back."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)
