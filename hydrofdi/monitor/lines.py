"""Lines of a monitor: one for each window, and one for each event; the same JSON everywhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hydrofdi.detectors.trained.following import ChartReading
from hydrofdi.detectors.trained.measuring import Verdict
from hydrofdi.records.streams import Event


class Condition(StrEnum):
    """The condition of the actuator, as the monitor judges it."""

    UNKNOWN = "unknown"
    """No window was judged yet, or none recently."""
    HEALTHY = "healthy"
    ALARM = "alarm"


@dataclass(frozen=True)
class WindowLine:
    """A window and its verdict.

    Attributes
    ----------
    number : int
        From 0; it continues over gaps and restarts, so that repeated lines can be recognised.
    start, end : float
        Instants of the first and last sample [s].
    condition : Condition
        Condition after this window.
    """

    number: int
    start: float
    end: float
    verdict: Verdict
    chart: ChartReading | None = None
    condition: Condition = Condition.UNKNOWN

    @property
    def alarm(self) -> bool | None:
        """Whether it is an alarm, that of the chart if there is one; None if it is not judged."""
        judged = self.verdict.alarm
        return judged if judged is None or self.chart is None else self.chart.alarm


Line = WindowLine | Event


def line_record(line: Line, unit: str = "1") -> dict[str, Any]:
    """A line as an object for JSON; numbers that are not finite are None."""
    if isinstance(line, Event):
        record = {"line": "event", "event": line.kind.value, "time": _finite(line.time)}
        record |= {"count": line.count, "is_end": line.is_end, "text": line.text}
        return record | ({"details": dict(line.details)} if line.details else {})
    verdict, chart = line.verdict, line.chart
    return {
        "line": "window",
        "number": line.number,
        "start": _finite(line.start),
        "end": _finite(line.end),
        "condition": line.condition.value,
        "score": _finite(verdict.score),
        "unit": unit,
        "alarm": line.alarm,
        "margin": _finite(verdict.margin),
        "beyond_limit": verdict.is_beyond,
        "fault": verdict.fault and {"kind": verdict.fault.kind, "text": verdict.fault.message},
        "doubt": verdict.doubt or None,
        "oil_temperature": _finite(verdict.temperature),
        "chart": chart and {
            "statistic": _finite(chart.statistic),
            "limit": _finite(chart.limit),
            "alarm": chart.alarm,
        },
    }  # fmt: skip


def is_said(line: Line) -> bool:
    """Whether a line is more than counted."""
    return not (isinstance(line, Event) and line.is_silent)


def _finite(number: float | None) -> float | None:
    return None if number is None or not math.isfinite(number) else float(number)
