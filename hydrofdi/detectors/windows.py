"""Windows that were judged, as a table, CSV and JSON; chunks of any samples, judged as a stream."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from hydrofdi.detectors.detector import Detector, JudgedWindow, Tally
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import line_record
from hydrofdi.errors import DataError
from hydrofdi.records.columns import RejectionError
from hydrofdi.records.memory import held, records_of
from hydrofdi.records.recording import samples_of
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.arguments import Names
from hydrofdi.settings.messages import HOLE, counted, number_text
from hydrofdi.tables.table import Column, Table, quantity


def watched(
    detector: Detector, chunks: Iterable[Any], frequency: float | None, channel: Names, unit: Names
) -> Iterator[dict[str, Any]]:
    """The lines of a stream, as they come."""
    file, state = detector.file, detector.start()
    for chunk in _chunks(chunks, frequency or file.sampling_frequency, channel, unit):
        state, lines = detector.step(state, chunk)
        yield from (line_record(line, file.unit) for line in lines)
    yield from (line_record(line, file.unit) for line in detector.end(state)[1])


def _chunks(chunks: Iterable[Any], frequency: float, channel: Names, unit: Names) -> Iterator[Chunk]:
    """Chunks with their instants; those without any follow each other."""
    n_before = 0
    for each in chunks:
        if isinstance(each, Chunk):
            yield each
            continue
        samples = held(each)
        source = records_of(samples, frequency if samples.time is None else None, channel, unit)
        if (n_record := len(source.table.record_ids)) > 1:
            raise DataError(f"{source.name}: has {counted(n_record, 'record')}; a chunk of a stream has one")
        try:
            _, channels, times, since = samples_of(source.table.row(0), source.config)
        except RejectionError as rejection:
            raise DataError(f"{source.name}: {rejection.remark.message}") from None
        n_time = next(iter(channels.values())).size
        if times is None:
            times = (n_before + np.arange(n_time)) / frequency
        elif not math.isnan(since):
            times = times + since
        yield Chunk(times, channels)
        n_before += n_time


_ROWS = 1_000
"""Windows in memory while a table is written."""


def windows_table(file: DetectorFile, windows: Sequence[JudgedWindow]) -> Table:
    """A row for each window, or record without any; people see alarms and scores beyond a limit in bold."""
    rows = [_fields(window, file) for window in windows]
    verdicts = [window.verdict for window in windows]
    faults = [each.fault.kind for each in verdicts if each.fault and each.is_beyond]
    were = "window beyond the limit was" if len(faults) == 1 else "windows beyond the limit were"
    doubts, notes = [each.doubt for each in verdicts if each.doubt], list[str]()
    if faults:
        notes.append(f"{len(faults):,} {were} not judged: {', '.join(sorted(set(faults)))}")
    if doubts:
        notes.append(f"doubtful: {counted(len(doubts), 'window')}, such as {doubts[0]}")
    beyond = [row for row, window in enumerate(windows) if window.verdict.is_beyond or window.alarm]

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
            Column("label", [each.label for each in windows], title="condition", is_text=True),
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
            *(column(name, "m^3/s") for name in ("leak", "leak_low", "leak_high")),
            column("chart_statistic", title=chart, is_shown=file.chart is not None),
            Column("alarm", alarms, title="verdict", text=[*map(_verdict, windows)], is_text=True),
            *words("cause", "fault", "reason", "doubt"),
        ),
        title=f"{file.score_name}, {file.feature.meaning}: alarm {file.alarm_text}",
        notes=tuple(notes),
        row="window",
    )


def _verdict(window: JudgedWindow) -> str:
    if (fault := window.verdict.fault) is not None:
        return f"not judged, {fault.kind}: {fault.message}"
    leak = f", {window.verdict.leak.size}" if window.verdict.leak else ""
    leak += window.verdict.cause.partition("as of a")[2].replace(" ", ", ", 1)
    doubt = f"; doubtful: {window.verdict.doubt}" if window.verdict.doubt else ""
    return (f"ALARM{leak}" if window.alarm else "healthy") + doubt


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
    config, limits = tally.file.config, tally.file.limits
    detector = {
        "indicator": config.indicator or None,
        "output": config.output or tally.file.score_name,
        "unit": tally.file.unit,
        "low": limits.low,
        "high": limits.high,
        "false_alarm_rate": limits.false_alarm_rate,
        "false_alarm_interval": list(limits.interval),
    }
    yield f'{{"detector": {json.dumps(detector)},\n"windows": ['
    between = "\n"
    for window in tally:
        yield between + json.dumps(_record(window, tally.file.unit), allow_nan=False)
        between = ",\n"
    rate = tally.rate
    summary = {
        "n_record": tally.n_record,
        "n_record_not_judged": len(tally.unjudged),
        "n_judged": tally.n_judged,
        "n_alarm": tally.n_alarm,
        "alarm_share": rate.value if tally.n_judged else None,
        "alarm_share_interval": [rate.low, rate.high] if tally.rests_on else None,
        "confidence": rate.confidence,
        "interval_rests_on": tally.rests_on,
        "hours": tally.hours,
        "not_judged": dict(sorted(tally.faults.items())),
        "n_not_judged_beyond_limit": tally.n_beyond,
        "n_doubtful": tally.n_doubtful,
        "consequence": tally.consequence.to_dict(),
    }
    yield f'\n],\n"summary": {json.dumps(summary, allow_nan=False)}}}\n'


def _record(window: JudgedWindow, unit: str) -> dict[str, Any]:
    """Keys of the lines of a monitor behind those of the record."""
    named = {"record_id": window.record_id, "source": window.source, "group": window.group or None}
    record = line_record(window, unit)
    return named | (record if window.number >= 0 else {"line": "record", "fault": record["fault"]})


def _fields(window: JudgedWindow, file: DetectorFile) -> dict[str, Any]:
    record, fault = _record(window, file.unit), window.verdict.fault
    leak = record.get("leak") or {}
    return record | {
        "leak": leak.get("flow"),
        "leak_low": leak.get("low"),
        "leak_high": leak.get("high"),
        "group": window.group,
        "unit": file.unit,
        "low": file.limits.low,
        "high": file.limits.high,
        "alarm": window.alarm,
        "chart_statistic": (record.get("chart") or {}).get("statistic"),
        "fault": "" if fault is None else fault.kind,
        "reason": "" if fault is None else fault.message,
        "doubt": window.verdict.doubt,
        "cause": window.verdict.cause,
    }
