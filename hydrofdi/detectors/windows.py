"""Windows of records, judged and counted; as a table, CSV and JSON."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import DetectorFile
from hydrofdi.detectors.lines import WindowLine, line_record
from hydrofdi.detectors.promise import consequence
from hydrofdi.detectors.verdicts import Leak, Verdict, without_scale
from hydrofdi.errors import Issue
from hydrofdi.evaluation.rates import FEWEST_GROUPS, Rate, alarm_rate
from hydrofdi.evaluation.scores import comparable
from hydrofdi.records import RecordBatch
from hydrofdi.records.streams import Chunk
from hydrofdi.settings.messages import HOLE, counted, number_text
from hydrofdi.tables.table import Column, Table, quantity

_RATE = 0.01
"""Share of the sampling frequency that a record may differ."""

_SAID_OF_WINDOWS = ("missing", "stuck", "gap")
"""Remarks on whole records that windows have as faults of their own."""

_ROWS = 1_000
"""Windows in memory while a table is written."""


def judged_windows(detector: Detector, batch: RecordBatch) -> Iterator[WindowLine]:
    """Every window of records, as the line of a stream which is each record by itself; of a record without
    any window, a line with a negative number and the reason as its fault.
    """
    for record in batch.rejected:
        rejection = Issue(record.remark.message, kind=record.remark.kind)
        yield _without(rejection, record_id=record.record_id, source=record.source, group=record.group)
    for row in range(batch.n_record):
        named: dict[str, Any] = {
            "record_id": batch.record_ids[row], "source": batch.sources[row], "group": batch.groups[row],
            "label": batch.labels[row] if batch.labels else "",
        }  # fmt: skip
        fault = _forbidden(detector.file, batch, row)
        lines = [] if fault else _lines(detector, batch, row)
        yield from (replace(line, **named) for line in lines)
        if not lines:
            yield _without(fault or _without_windows(detector.file, batch), **named)


def _without(fault: Issue, **named: Any) -> WindowLine:
    return WindowLine(-1, math.nan, math.nan, Verdict(fault=fault), **named)


def _lines(detector: Detector, records: RecordBatch, row: int) -> list[WindowLine]:
    samples = {channel: values[row] for channel, values in records.channels.items()}
    _, told = detector.step(detector.start(), Chunk(records.time, samples))
    lines = [line for line in told if isinstance(line, WindowLine)]
    for remark in records.remarks[row]:
        if remark.kind == "unended" and lines and lines[-1].end == records.time[-1]:
            doubt = "; ".join(filter(None, (lines[-1].verdict.doubt, remark.message)))
            lines[-1] = replace(lines[-1], verdict=replace(lines[-1].verdict, doubt=doubt))
    return lines


def _forbidden(file: DetectorFile, records: RecordBatch, row: int) -> Issue | None:
    """Why a record cannot be taken for a stream of the detector."""
    if missing := [channel for channel in file.channels if channel not in records.channels]:
        unused = [remark.message for remark in records.remarks[row] if remark.kind == "unused"]
        return Issue("; ".join([f"has no {' and no '.join(missing)}", *unused]), kind="missing_channel")
    if abs(records.sampling_frequency / file.sampling_frequency - 1.0) > _RATE:
        rates = f"{records.sampling_frequency:.4g} Hz instead of {file.sampling_frequency:.4g} Hz"
        return Issue(f"is sampled at {rates}", kind="other_rate")
    if obstacle := without_scale(records, file.channels):
        return Issue(obstacle, kind="no_scale")
    for remark in records.remarks[row]:
        concerns = not remark.where or remark.where in file.channels
        if remark.is_unusable and concerns and remark.kind not in _SAID_OF_WINDOWS:
            return Issue(remark.message, kind=remark.kind)
    return None


def _without_windows(file: DetectorFile, records: RecordBatch) -> Issue:
    lasts, window = f"lasts {records.duration:.4g} s", file.config.window
    duration = f"{file.n_sample / file.sampling_frequency:.4g} s"
    if window.by == "cycle" and records.n_time >= file.n_sample:
        return Issue(f"has no cycle: no {window.edge} edge of {window.channel} in time", kind="no_cycle")
    return Issue(f"{lasts}, and a window {duration}", kind="short_record")


class Tally:
    """Windows on their way, counted.

    ``n_judged`` windows were judged, ``n_alarm`` of them with an alarm, ``n_doubtful`` with a doubt, of which
    ``first_doubt`` is one. ``faults``: kind → windows, or records without any, that were not judged,
    ``n_beyond`` of them with a score beyond a limit all the same. ``unjudged``: source and record of those of
    which nothing was judged nor novel, which is a finding → the first reason.
    """

    def __init__(self, file: DetectorFile, windows: Iterable[WindowLine]) -> None:
        self.file, self._windows = file, windows
        self.faults: Counter[str] = Counter()
        self.n_judged = self.n_alarm = self.n_beyond = self.n_doubtful = 0
        self.first_doubt, self.group_noun = "", "records"
        self.unjudged: dict[tuple[str, str], str] = {}
        self._records: set[tuple[str, str]] = set()
        self._alarms, self._groups, self._blocks = list[float](), list[str](), list[str]()
        self._leaks: list[Leak] = []
        self._duration = file.n_sample / file.sampling_frequency
        self._every = min(file.n_every / file.sampling_frequency, self._duration)

    def __iter__(self) -> Iterator[WindowLine]:
        for window in self._windows:
            self._count(window)
            yield window

    def _count(self, window: WindowLine) -> None:
        record, verdict = (window.source, window.record_id), window.verdict
        if record not in self._records:
            self._records.add(record)
            self.unjudged[record] = verdict.fault.message if verdict.fault else ""
        if verdict.fault is not None:
            self.faults[verdict.fault.kind] += 1
            self.n_beyond += bool(verdict.is_beyond)
        if verdict.doubt:
            self.n_doubtful += 1
            self.first_doubt = self.first_doubt or verdict.doubt
        if verdict.fault is None or verdict.fault.kind == "novel":
            self.unjudged.pop(record, None)
        if window.alarm is not None:
            name = " ".join(record)
            self.n_judged += 1
            self.n_alarm += window.alarm
            self.group_noun = "groups" if window.group else self.group_noun
            self._alarms.append(float(window.alarm))
            self._groups.append(window.group or name)
            self._blocks.append(f"{name} {int(comparable(window.start / self._duration))}")
            if window.alarm and verdict.leak is not None:
                self._leaks.append(verdict.leak)

    @property
    def n_record(self) -> int:
        """Records, those among them that were rejected."""
        return len(self._records)

    @property
    def hours(self) -> float:
        """Time that was judged [h]: of overlapping windows, what each adds."""
        return self.n_judged * self._every / 3600.0

    @property
    def n_group(self) -> int:
        """Groups of which something was judged; records if nobody stated groups, as ``group_noun`` says."""
        return len(set(self._groups))

    @property
    def rests_on(self) -> str | None:
        """What the interval of the share takes as independent: ``groups`` or ``records``; ``windows`` that do
        not overlap if these are too few; None if nothing is judged.
        """
        if self.n_group >= FEWEST_GROUPS:
            return self.group_noun
        return "windows" if self.n_judged else None

    @property
    def consequence(self) -> tuple[str, dict[str, Any]]:
        """What the alarms come to, in words and for JSON; the leak is their median."""
        leak = Leak(*np.median(self._leaks, axis=0).tolist()) if self._leaks else None
        return consequence(self.file, self.n_judged, self.n_alarm, leak)

    @property
    def rate(self) -> Rate:
        """The share of judged windows that are alarms, with its interval."""
        groups: list[str] | None = self._groups
        if self.rests_on == "windows":
            groups = self._blocks if self._every < self._duration else None
        return alarm_rate(self._alarms, groups=groups, confidence=self.file.config.confidence)

    def table(self, windows: Sequence[WindowLine]) -> Table:
        """A row for each window, or record without any; alarms and scores beyond a limit are bold."""
        file, rows = self.file, [_fields(window, self.file) for window in windows]
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
        # a score of several numbers has the unit of the first, but is not its size
        is_size = file.config.score is None or file.config.score.kind != "either"
        chart = f"chart, of {number_text(file.chart.limit, 3)}" if file.chart else ""
        return Table(
            (
                column("record_id", title="record", is_text=True, is_shown=True),
                Column("label", [each.label for each in windows], title="condition", is_text=True),
                *words("source", "group"),
                column("number"),
                column("start", "s", text=lambda at: HOLE if at is None else f"{at:.12g}", is_shown=True),
                column("end", "s"),
                replace(numbers, strong=beyond, is_shown=is_size),
                *words("unit"),
                column("low"),
                column("high"),
                column(
                    "margin",
                    title="margin [spreads]",
                    text=lambda at: HOLE if at is None else f"{at:+.2f}".replace("-", "−"),
                    is_shown=True,
                    strong=() if is_size else beyond,
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

    def csv(self) -> Iterator[str]:
        """A line for each window, or record without any; an empty field where there is no number."""
        windows, header = iter(self), True
        while (some := [*islice(windows, _ROWS)]) or header:
            table, names = self.table(some), {"start": "start_s", "end": "end_s"}
            renamed = (replace(each, name=names.get(each.name, each.name)) for each in table.content)
            yield replace(table, content=tuple(renamed)).to_csv(header=header)
            header = False

    def json(self) -> Iterator[str]:
        """Parts of one JSON object: the detector, an object for each window, and what they come to."""
        config, limits, unit = self.file.config, self.file.limits, self.file.unit
        detector = {
            "indicator": config.indicator or None,
            "output": config.output or self.file.score_name,
            "unit": unit,
            "low": limits.low,
            "high": limits.high,
            "false_alarm_rate": limits.false_alarm_rate,
            "false_alarm_interval": list(limits.interval),
        }
        yield f'{{"detector": {json.dumps(detector)},\n"windows": ['
        between = "\n"
        for window in self:
            yield between + json.dumps(_record(window, unit), allow_nan=False)
            between = ",\n"
        rate = self.rate
        summary = {
            "n_record": self.n_record,
            "n_record_not_judged": len(self.unjudged),
            "n_judged": self.n_judged,
            "n_alarm": self.n_alarm,
            "alarm_share": rate.value if self.n_judged else None,
            "alarm_share_interval": [rate.low, rate.high] if self.rests_on else None,
            "confidence": rate.confidence,
            "interval_rests_on": self.rests_on,
            "hours": self.hours,
            "not_judged": dict(sorted(self.faults.items())),
            "n_not_judged_beyond_limit": self.n_beyond,
            "n_doubtful": self.n_doubtful,
            "consequence": self.consequence[1],
        }
        yield f'\n],\n"summary": {json.dumps(summary, allow_nan=False)}}}\n'


def _verdict(window: WindowLine) -> str:
    if (fault := window.verdict.fault) is not None:
        return f"not judged, {fault.kind}: {fault.message}"
    leak = f", {window.verdict.leak.size}" if window.verdict.leak else ""
    leak += window.verdict.cause.partition("as of a")[2].replace(" ", ", ", 1)
    doubt = f"; doubtful: {window.verdict.doubt}" if window.verdict.doubt else ""
    return (f"ALARM{leak}" if window.alarm else "healthy") + doubt


def _record(window: WindowLine, unit: str) -> dict[str, Any]:
    """Keys of the lines of a monitor behind those of the record."""
    named = {"record_id": window.record_id, "source": window.source, "group": window.group or None}
    record = line_record(window, unit)
    return named | (record if window.number >= 0 else {"line": "record", "fault": record["fault"]})


def _fields(window: WindowLine, file: DetectorFile) -> dict[str, Any]:
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
