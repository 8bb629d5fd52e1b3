"""The terminal: results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import Any


def tell(*messages: str) -> None:
    """Print messages on standard error, a line each; a terminal shows long ones broken at blanks."""
    sys.stdout.flush()  # both may go into one pipe
    for message in messages:
        for line in message.split("\n"):
            print(_broken(line) if sys.stderr.isatty() else line, file=sys.stderr)


def draw(found: Any, figure: Path | None) -> None:
    """Draw a result to a file, if there is one."""
    if figure is not None:
        from hydrofdi.report.figures import save_figure

        save_figure(found.plot(), figure)
        tell(f"drew {figure}")


@contextmanager
def told_on_standard_error() -> Iterator[None]:
    """In this context, what the package logs, such as progress, goes to standard error."""
    log, handler = logging.getLogger("hydrofdi"), logging.StreamHandler()
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


def answer(found: Any, *, json: bool = False) -> int:
    """Print what a command found as text or JSON, what stands beside it on standard error; its exit code."""
    if json:
        print_json(found.to_dict())
    else:
        for _, lines in found.lines(width()):
            print_lines(lines)
    tell(*found.asides())
    return int(not found)


_PLAIN_WIDTH = 100
"""Columns of text if the output is not a terminal."""

_STYLES = {"bold": "1", "dim": "2", "underlined": "1;4"}
"""Style → its code on a terminal."""


def width() -> int:
    """Columns of standard output: those of a terminal, else as ``COLUMNS`` says, or 100."""
    return get_terminal_size((_PLAIN_WIDTH, 0)).columns


def print_lines(lines: Iterable[tuple[str, str]]) -> None:
    """Print lines with their styles; a terminal shows styles, and long lines broken at blanks."""
    is_terminal = sys.stdout.isatty()
    for line, style in lines:
        text = _broken(line) if is_terminal else line
        code = _STYLES.get(style) if is_terminal and os.environ.get("TERM") != "dumb" else None
        write_out(f"\033[{code}m{text}\033[0m\n" if code else f"{text}\n")


def _broken(line: str) -> str:
    if len(line) <= (room := width()):
        return line
    return fill(line, room, break_long_words=False, break_on_hyphens=False)
