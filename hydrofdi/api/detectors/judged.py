"""Judged windows as a table."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from hydrofdi.api.detectors.windows import JudgedWindow
from hydrofdi.api.table import Table
from hydrofdi.settings.counting import counted

_NAMES = (
    "record_id",
    "source",
    "group",
    "start",
    "end",
    "score",
    "margin",
    "beyond_limit",
    "alarm",
    "fault",
    "reason",
    "doubt",
)


def table_of(windows: Iterable[JudgedWindow], unit: str) -> Table:
    """A row for each window; the score in a unit."""
    rows = [_row(window) for window in windows]
    columns: dict[str, Any] = {name: [row[name] for row in rows] for name in _NAMES}
    if None in columns["alarm"]:
        columns["alarm"] = np.array(columns["alarm"], dtype=object)
    units = {"start": "s", "end": "s", "score": unit}
    return Table(
        "window", columns, units, remarks=[*_not_judged(rows), *_doubtful(rows)], always_shown=("alarm",)
    )


def _not_judged(rows: Sequence[dict[str, Any]]) -> list[str]:
    """How many windows beyond a limit were not judged, and why."""
    faults = [row["fault"] for row in rows if row["beyond_limit"] and row["alarm"] is None]
    were = "window beyond the limit was" if len(faults) == 1 else "windows beyond the limit were"
    return [f"{len(faults):,} {were} not judged: {', '.join(sorted(set(faults)))}"] if faults else []


def _doubtful(rows: Sequence[dict[str, Any]]) -> list[str]:
    """How many verdicts are doubtful, and the first reason."""
    doubts = [row["doubt"] for row in rows if row["doubt"]]
    return [f"doubtful: {counted(len(doubts), 'window')}, such as {doubts[0]}"] if doubts else []


def _row(window: JudgedWindow) -> dict[str, Any]:
    line, fault = window.line, window.fault
    return {
        "record_id": window.record_id,
        "source": window.source,
        "group": window.group,
        "start": None if line is None else line.start,
        "end": None if line is None else line.end,
        "score": None if line is None else line.verdict.score,
        "margin": None if line is None else line.verdict.margin,
        "beyond_limit": window.is_beyond,
        "alarm": window.alarm,
        "fault": "" if fault is None else fault.kind,
        "reason": "" if fault is None else fault.text,
        "doubt": window.doubt,
    }
