"""The terminal: results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

_PLAIN_WIDTH = 100
"""Columns of text if the output is not a terminal."""


def tell(message: str) -> None:
    """Print a message on standard error."""
    print(message, file=sys.stderr)


class _Told(logging.Handler):
    """Shows what the package logs as messages."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print the message of a record."""
        tell(record.getMessage())


@contextmanager
def told_on_standard_error() -> Iterator[None]:
    """In this context, what the package logs, such as progress, goes to standard error."""
    log, handler = logging.getLogger("hydrofdi"), _Told()
    before = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before)


def write_out(text: str) -> None:
    """Write a text to standard output, unchanged."""
    sys.stdout.write(text)


def print_json(record: Any) -> None:
    """Print a record as JSON on standard output."""
    write_out(json.dumps(record, indent=2, allow_nan=False) + "\n")


def terminal() -> Console:
    """The console on standard output; if that is not a terminal, as wide as ``COLUMNS`` says, or 100."""
    stated = os.environ.get("COLUMNS", "")
    width = int(stated) if stated.isdecimal() and int(stated) > 0 else None
    if width is None and not sys.stdout.isatty():
        width = _PLAIN_WIDTH
    from rich.console import Console

    console = Console(width=width, highlight=False, markup=False)
    console.on_broken_pipe = _raise_broken_pipe  # type: ignore[method-assign]
    return console


def _raise_broken_pipe() -> None:
    """Let `main` decide on the exit code if the reader leaves early, as ``head`` does."""
    raise BrokenPipeError
