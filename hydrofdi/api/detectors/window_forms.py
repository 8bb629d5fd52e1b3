"""Judged windows as CSV and JSON, written window by window."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import chain
from typing import Any

from hydrofdi.api.detectors.tally import Tally
from hydrofdi.api.detectors.windows import JudgedWindow
from hydrofdi.monitor.line_record import line_record
from hydrofdi.report.forms import separated

_COLUMNS = (
    "record_id", "source", "group", "number", "start_s", "end_s", "score", "unit", "low", "high", "alarm",
    "margin", "beyond_limit", "chart_statistic", "fault", "reason", "doubt",
)  # fmt: skip


def csv_lines(tally: Tally) -> Iterator[str]:
    """A line for each window, or record without any; an empty field where there is no number."""
    limits = {"low": tally.file.limits.low, "high": tally.file.limits.high}
    fields = ({"unit": tally.file.unit} | limits | _fields(window, tally.file.unit) for window in tally)
    return separated.csv_lines(chain([_COLUMNS], ([each.get(name) for name in _COLUMNS] for each in fields)))


def json_parts(tally: Tally) -> Iterator[str]:
    """Parts of one JSON object: the detector, an object for each window, and what they come to."""
    yield f'{{"detector": {json.dumps(_detector(tally))},\n"windows": ['
    between = "\n"
    for window in tally:
        yield between + json.dumps(_record(window, tally.file.unit), allow_nan=False)
        between = ",\n"
    yield f'\n],\n"summary": {json.dumps(_summary(tally), allow_nan=False)}}}\n'


def _detector(tally: Tally) -> dict[str, Any]:
    config, limits = tally.file.config, tally.file.limits
    return {
        "indicator": config.indicator,
        "output": config.output,
        "unit": tally.file.unit,
        "low": limits.low,
        "high": limits.high,
        "false_alarm_rate": limits.false_alarm_rate,
        "false_alarm_interval": list(limits.interval),
    }


def _record(window: JudgedWindow, unit: str) -> dict[str, Any]:
    """Keys of the lines of a monitor behind those of the record."""
    named = {"record_id": window.record_id, "source": window.source, "group": window.group or None}
    if window.line is not None:
        return {**named, **line_record(window.line, unit)}
    fault = window.record_fault
    return {**named, "line": "record", "fault": fault and {"kind": fault.kind, "text": fault.text}}


def _fields(window: JudgedWindow, unit: str) -> dict[str, Any]:
    record = _record(window, unit)
    fault, chart = record.pop("fault") or {}, record.pop("chart", None) or {}
    fields = {
        **record,
        "start_s": record.get("start"),
        "end_s": record.get("end"),
        "alarm": window.alarm,
        "chart_statistic": chart.get("statistic"),
        "fault": fault.get("kind"),
        "reason": fault.get("text"),
    }
    return {name: fields[name] for name in _COLUMNS if name in fields}


def _summary(tally: Tally) -> dict[str, Any]:
    rate = tally.rate
    judged = tally.n_judged > 0
    return {
        "n_record": tally.n_record,
        "n_record_not_judged": len(tally.unjudged),
        "n_judged": tally.n_judged,
        "n_alarm": tally.n_alarm,
        "alarm_share": rate.value if judged else None,
        "alarm_share_interval": [rate.low, rate.high] if tally.rests_on else None,
        "confidence": rate.confidence,
        "interval_rests_on": tally.rests_on,
        "hours": tally.hours,
        "not_judged": dict(sorted(tally.faults.items())),
        "n_not_judged_beyond_limit": tally.n_beyond,
        "n_doubtful": tally.n_doubtful,
    }
