"""Ctrl-C and SIGTERM during a sweep."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruption(on_request: Callable[[], None]) -> Iterator[list[int]]:
    """The first Ctrl-C in this context is noted and calls a function; the second and SIGTERM stop at once."""
    requests: list[int] = []

    def handle(number: int, frame: FrameType | None) -> None:
        if number == signal.SIGTERM or requests:
            raise KeyboardInterrupt
        requests.append(number)
        on_request()

    previous = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield requests
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
