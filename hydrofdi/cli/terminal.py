"""The terminal: results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


def tell(*messages: str) -> None:
    """Print messages on standard error, a line each."""
    for message in messages:
        print(message, file=sys.stderr)


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


def answer(found: Any, parts: str | Callable[[Any], Iterable[Any]], *, json: bool) -> None:
    """Print a result as JSON, or its text, or its parts: lines, titles and tables."""
    if json:
        print_json(found.to_dict() if hasattr(found, "to_dict") else found)
        return
    if isinstance(parts, str):
        write_out(f"{parts}\n")
        return
    from hydrofdi.cli.tables import print_parts

    print_parts(parts(found))


def facts(named: Iterable[tuple[str, object]], width: int = 10) -> list[str]:
    """A line for each fact that has a text, below each other."""
    return [f"{name:<{width}}{text}" for name, text in named if str(text)]
