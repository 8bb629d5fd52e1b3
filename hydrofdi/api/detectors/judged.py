"""Judged windows as a table, and written as they come as CSV and JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from hydrofdi.api.detectors.windows import JudgedWindow, Tally
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.monitor.lines import line_record
from hydrofdi.report.table import Column, Table, quantity
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, number_text

_ROWS = 1_000
"""Windows in memory while a table is written."""


def windows_table(file: DetectorFile, windows: Sequence[JudgedWindow]) -> Table:
    """A row for each window, or record without any; people see alarms and scores beyond a limit in bold."""
    rows = [_fields(window, file) for window in windows]
    beyond = [row for row, window in enumerate(windows) if window.is_beyond or window.alarm]

    def column(name: str, unit: str = "", *, is_shown: bool = False, **more: Any) -> Column:
        return Column(name, [row.get(name) for row in rows], unit, is_shown=is_shown, **more)

    def words(*names: str) -> list[Column]:
        return [column(name, is_text=True) for name in names]

    alarms = np.array([window.alarm for window in windows], dtype=object)
    scores = [row.get("score") for row in rows]
    numbers = quantity("score", scores, file.unit, sizes=[file.limits.low, file.limits.high])
    chart = f"chart, of {number_text(file.chart.limit, 3)}" if file.chart else ""
    return Table(
        (
            column("record_id", title="record", is_text=True, is_shown=True),
            *words("source", "group"),
            column("number"),
            column("start", "s", text=lambda at: HOLE if at is None else f"{at:.12g}", is_shown=True),
            column("end", "s"),
            replace(numbers, strong=beyond),
            *words("unit"),
            column("low"),
            column("high"),
            column(
                "margin",
                title="margin [spreads]",
                text=lambda at: HOLE if at is None else f"{at:+.2f}".replace("-", "−"),
                is_shown=True,
            ),
            column("beyond_limit"),
            column("chart_statistic", title=chart, is_shown=file.chart is not None),
            Column("alarm", alarms, title="verdict", text=[*map(_verdict, windows)], is_text=True),
            *words("fault", "reason", "doubt"),
        ),
        title=f"{file.score_name}, {file.feature.meaning}: alarm {file.limits_text}",
        notes=(*_not_judged(rows), *_doubtful(rows)),
        row="window",
    )


def _not_judged(rows: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    """How many windows beyond a limit were not judged, and why."""
    faults = [row["fault"] for row in rows if row.get("beyond_limit") and row["alarm"] is None]
    were = "window beyond the limit was" if len(faults) == 1 else "windows beyond the limit were"
    return (f"{len(faults):,} {were} not judged: {', '.join(sorted(set(faults)))}",) if faults else ()


def _doubtful(rows: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    """How many verdicts are doubtful, and the first reason."""
    doubts = [row["doubt"] for row in rows if row["doubt"]]
    return (f"doubtful: {counted(len(doubts), 'window')}, such as {doubts[0]}",) if doubts else ()


def _verdict(window: JudgedWindow) -> str:
    if window.fault is not None:
        return f"not judged, {window.fault.kind}: {window.fault.message}"
    doubt = f", doubtful: {window.doubt}" if window.doubt else ""
    return ("ALARM" if window.alarm else "healthy") + doubt


def csv_lines(tally: Tally) -> Iterator[str]:
    """A line for each window, or record without any; an empty field where there is no number."""
    windows, header = iter(tally), True
    while (some := [*islice(windows, _ROWS)]) or header:
        table = windows_table(tally.file, some)
        names = {"start": "start_s", "end": "end_s"}
        renamed = (replace(each, name=names.get(each.name, each.name)) for each in table.content)
        yield replace(table, content=tuple(renamed)).to_csv(header=header)
        header = False


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
        "indicator": config.indicator or None,
        "output": config.output or tally.file.score_name,
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
    return {**named, "line": "record", "fault": fault and {"kind": fault.kind, "text": fault.message}}


def _fields(window: JudgedWindow, file: DetectorFile) -> dict[str, Any]:
    record, fault = _record(window, file.unit), window.fault
    return record | {
        "group": window.group,
        "unit": file.unit,
        "low": file.limits.low,
        "high": file.limits.high,
        "alarm": window.alarm,
        "chart_statistic": (record.get("chart") or {}).get("statistic"),
        "fault": "" if fault is None else fault.kind,
        "reason": "" if fault is None else fault.message,
        "doubt": window.doubt,
    }


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
