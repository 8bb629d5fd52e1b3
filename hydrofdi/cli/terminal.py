"""The terminal: results go to standard output, everything else to standard error."""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from shutil import get_terminal_size
from textwrap import fill
from typing import Any


def tell(*messages: str) -> None:
    """Print messages on standard error, a line each; a terminal shows long ones broken at blanks."""
    width = get_terminal_size().columns
    for message in messages:
        lines = message.split("\n")
        if sys.stderr.isatty():
            lines = [fill(each, width, break_long_words=False, break_on_hyphens=False) for each in lines]
        print("\n".join(lines), file=sys.stderr)


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


_MOST_VALUES = 6
"""Most values of a list that are shown; of longer ones, the ends."""


def facts(record: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """A line for each fact of a record, below each other; a record within it stands below its name."""
    known = {name: found for name, found in record.items() if found or (found == 0 and found is not False)}
    width = max(map(len, known), default=0) + 2
    for name, found in known.items():
        title = name if "." in name else name.replace("_", " ")
        is_deep = isinstance(found, Mapping) and any("." in key for key in found)
        if is_deep and "." not in name:
            yield f"{indent}{title}"
            yield from facts(found, f"{indent}  ")
        else:
            yield f"{indent}{title:<{width}}{_text(name, found)}"


def _text(name: str, found: Any) -> str:
    """A value as people read it: parameters with their units, durations and sizes by their names."""
    from hydrofdi.settings.readable import HOLE, number_text, shown_bytes, time_text

    if isinstance(found, tuple):
        return " → ".join(_text(name, each) for each in found)
    if isinstance(found, list):
        shown = found if len(found) <= _MOST_VALUES else [found[0], "…", found[-1]]
        text = ", ".join(_text(name, each) for each in shown)
        return text if shown is found else f"{len(found):,} values, {text}"
    if "." in name and found != "…":
        from hydrofdi.config.request import parameter_names
        from hydrofdi.config.shown_values import shown_value

        parameter = name.rpartition(": ")[2]
        if parameter in parameter_names() and found is not None:
            return shown_value(parameter, found)
    if isinstance(found, Mapping):
        return ", ".join(f"{key} {_text(key, each)}" for key, each in found.items())
    if isinstance(found, float):
        return time_text(found) if "seconds" in name else number_text(found)
    if isinstance(found, int) and not isinstance(found, bool):
        return shown_bytes(found) if name.endswith("bytes") else f"{found:,}"
    return HOLE if found is None else str(found)
