"""Lines as JSON objects: the same on standard output, in the log and in messages."""

from __future__ import annotations

import json
import math
from typing import Any

from hydrofdi.monitor.lines import Event, Line, WindowLine


def line_record(line: Line, unit: str = "1") -> dict[str, Any]:
    """A line as an object for JSON; numbers that are not finite are None.

    Parameters
    ----------
    line : WindowLine or Event
    unit : str
        Unit of scores, from the detector's file.

    Returns
    -------
    dict
        ``line`` is ``window`` or ``event``; instants (``start``, ``end``, ``time``) are in seconds.
    """
    return _window(line, unit) if isinstance(line, WindowLine) else _event(line)


def line_text(line: Line, unit: str = "1") -> str:
    """A line as one line of JSON, with a line end."""
    return json.dumps(line_record(line, unit), ensure_ascii=False, allow_nan=False) + "\n"


def _window(line: WindowLine, unit: str) -> dict[str, Any]:
    verdict, chart = line.verdict, line.chart
    return {
        "line": "window",
        "number": line.number,
        "start": _finite(line.start),
        "end": _finite(line.end),
        "condition": line.condition.value,
        "score": _finite(verdict.score),
        "unit": unit,
        "alarm": verdict.alarm,
        "margin": _finite(verdict.margin),
        "beyond_limit": verdict.is_beyond,
        "fault": verdict.fault and {"kind": verdict.fault.kind, "text": verdict.fault.message},
        "doubt": verdict.doubt or None,
        "chart": chart and {
            "statistic": _finite(chart.statistic),
            "limit": _finite(chart.limit),
            "alarm": chart.alarm,
        },
    }  # fmt: skip


def _event(line: Event) -> dict[str, Any]:
    record = {"line": "event", "event": line.kind.value, "time": _finite(line.time)}
    return {**record, "count": line.count, "is_end": line.is_end, "text": line.text}


def _finite(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else float(number)
