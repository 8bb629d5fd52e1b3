"""A trained detector and records of any source → what it says of each window, as a table, CSV and JSON."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from typing import Any

import numpy as np

from hydrofdi.api.detectors.healthy_records import analysed_batches
from hydrofdi.api.sources import Said, held, records_of
from hydrofdi.detectors.trained.consequence import Consequence, consequence
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.following import Follower
from hydrofdi.detectors.trained.measuring import without_scale
from hydrofdi.errors import DataError, Issue
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.roc import FEWEST_GROUPS
from hydrofdi.evaluation.scores import comparable
from hydrofdi.monitor.lines import Condition, Line, WindowLine, line_record
from hydrofdi.monitor.watch import Watch, judging_of
from hydrofdi.records import Channel, RecordBatch, RecordSource
from hydrofdi.records.columns import RejectionError
from hydrofdi.records.recording import samples_of
from hydrofdi.records.streams import Chunk, Event, EventKind
from hydrofdi.report.table import Column, Table, quantity
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, number_text

__all__ = ["Condition", "Event", "EventKind", "JudgedWindow", "Line", "Tally", "WindowLine"]

_RATE = 0.01
"""Share of the sampling frequency that a record may differ."""

_SAID_OF_WINDOWS = ("missing", "stuck")
"""Remarks on channels of whole records that windows have as faults of their own."""


@dataclass(frozen=True)
class JudgedWindow:
    """What a detector says of a window of a record, as the line of a monitor which is given the record as a
    stream; or of a record without any window, and why. ``label``: condition of the record, where it is known.
    """

    record_id: str
    source: str
    group: str
    line: WindowLine | None
    record_fault: Issue | None = None
    label: str = ""

    @property
    def fault(self) -> Issue | None:
        """Why nothing is judged."""
        return self.record_fault if self.line is None else self.line.verdict.fault

    @property
    def doubt(self) -> str:
        """Why the verdict is doubtful; empty if it is not."""
        return "" if self.line is None else self.line.verdict.doubt

    @property
    def is_beyond(self) -> bool:
        """Whether the score is beyond a limit of the threshold, also if nothing is judged."""
        return self.line is not None and bool(self.line.verdict.is_beyond)

    @property
    def alarm(self) -> bool | None:
        """That of the chart if there is one, or of the threshold; None if the window is not judged."""
        return None if self.line is None else self.line.alarm


def channels_read(file: DetectorFile) -> tuple[Channel, ...]:
    """Channels that a detector reads: what it measures, and the drive where that starts its windows."""
    return judging_of(file).needs


def judged_windows(file: DetectorFile, source: RecordSource) -> Iterator[JudgedWindow]:
    """Every window of every record: what a monitor says that is given each record as a stream by itself."""
    watch, channels = Watch(file), channels_read(file)
    for batch in analysed_batches(source, labels=True):
        for record in batch.rejected:
            fault = Issue(record.remark.message, kind=record.remark.kind)
            yield JudgedWindow(record.record_id, record.source, record.group, None, fault)
        for row in range(batch.n_record):
            named = partial(
                JudgedWindow,
                batch.record_ids[row],
                batch.sources[row],
                batch.groups[row],
                label=batch.labels[row] if batch.labels else "",
            )
            fault_or_lines = _forbidden(file, channels, batch, row) or _lines(watch, batch, row)
            if isinstance(fault_or_lines, Issue):
                yield named(None, fault_or_lines)
            elif not fault_or_lines:
                yield named(None, _without_windows(file, batch))
            else:
                yield from map(named, fault_or_lines)


def _lines(watch: Watch, records: RecordBatch, row: int) -> list[WindowLine]:
    samples = {channel: values[row] for channel, values in records.channels.items()}
    _, found = watch.step(watch.start(), Chunk(records.time, samples))
    lines = [line for line in found if isinstance(line, WindowLine)]
    for remark in records.remarks[row]:
        if remark.kind == "unended" and lines and lines[-1].end == records.time[-1]:
            doubt = "; ".join(filter(None, (lines[-1].verdict.doubt, remark.message)))
            lines[-1] = replace(lines[-1], verdict=replace(lines[-1].verdict, doubt=doubt))
    return lines


def _forbidden(
    file: DetectorFile, channels: tuple[Channel, ...], records: RecordBatch, row: int
) -> Issue | None:
    """Why a record cannot be taken for a stream of the detector."""
    if missing := [channel for channel in channels if channel not in records.channels]:
        unused = [remark.message for remark in records.remarks[row] if remark.kind == "unused"]
        return Issue("; ".join([f"has no {' and no '.join(missing)}", *unused]), kind="missing_channel")
    if abs(records.sampling_frequency / file.sampling_frequency - 1.0) > _RATE:
        rates = f"{records.sampling_frequency:.4g} Hz instead of {file.sampling_frequency:.4g} Hz"
        return Issue(f"is sampled at {rates}", kind="other_rate")
    if obstacle := without_scale(records, channels):
        return Issue(obstacle, kind="no_scale")
    for remark in records.remarks[row]:
        concerns = remark.where in channels and remark.kind not in _SAID_OF_WINDOWS
        if remark.is_unusable and (not remark.where or concerns):
            return Issue(remark.message, kind=remark.kind)
    return None


def _without_windows(file: DetectorFile, records: RecordBatch) -> Issue:
    lasts, window = f"lasts {records.duration:.4g} s", file.config.window
    if window.by == "estimate":
        return Issue(f"{lasts}, and the first estimate comes later", kind="short_record")
    duration = f"{file.n_sample / file.sampling_frequency:.4g} s"
    if window.by == "cycle" and records.n_time >= file.n_sample:
        return Issue(f"has no cycle: no {window.edge} edge of {window.channel} in time", kind="no_cycle")
    return Issue(f"{lasts}, and a window {duration}", kind="short_record")


def watched(file: DetectorFile, chunks: Iterable[Any], said: Said) -> Iterator[dict[str, Any]]:
    """The lines of a stream, as they come."""
    watch = Watch(file)
    state = watch.start()
    for chunk in _chunks(chunks, said, said.frequency or file.sampling_frequency):
        state, lines = watch.step(state, chunk)
        yield from (line_record(line, file.unit) for line in lines)
    yield from (line_record(line, file.unit) for line in watch.end(state)[1])


def _chunks(chunks: Iterable[Any], said: Said, frequency: float) -> Iterator[Chunk]:
    """Chunks with their instants; those without any follow each other."""
    n_before = 0
    for each in chunks:
        if isinstance(each, Chunk):
            yield each
            continue
        samples = held(each)
        source = records_of(samples, frequency if samples.time is None else None, said.channel, said.unit)
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


class Tally:
    """Windows on their way, counted.

    ``faults``: kind → windows, or records without any, that were not judged, ``n_beyond`` of them with a
    score beyond a limit all the same. ``n_doubtful`` judged ones, with the ``first_doubt``. ``unjudged``:
    source and record of those of which nothing was judged → the first reason.
    """

    def __init__(self, file: DetectorFile, windows: Iterable[JudgedWindow]) -> None:
        self.file = file
        self.faults: Counter[str] = Counter()
        self.n_beyond = self.n_doubtful = 0
        self.first_doubt = ""
        self.unjudged: dict[tuple[str, str], str] = {}
        self._windows = windows
        self._outcomes: list[float] = []
        self._alarming: list[float] = []
        self._groups: list[str] = []
        self._blocks: list[str] = []
        self._records: set[tuple[str, str]] = set()
        self._has_groups = False
        self._by_estimate, frequency = file.config.window.by == "estimate", file.sampling_frequency
        n_sample = Follower(file).n_every if self._by_estimate else file.n_sample
        self._duration = n_sample / frequency
        self._every = min(file.config.window.n_every(n_sample, frequency) / frequency, self._duration)

    def __iter__(self) -> Iterator[JudgedWindow]:
        for window in self._windows:
            self._count(window)
            yield window

    def _count(self, window: JudgedWindow) -> None:
        record = (window.source, window.record_id)
        if record not in self._records:
            self._records.add(record)
            self.unjudged[record] = window.fault.message if window.fault else ""
        if window.fault is not None:
            self.faults[window.fault.kind] += 1
            self.n_beyond += window.is_beyond
        if window.doubt:
            self.n_doubtful += 1
            self.first_doubt = self.first_doubt or window.doubt
        if window.alarm is not None and window.line is not None:
            self.unjudged.pop(record, None)
            self._outcomes.append(float(window.alarm))
            if window.alarm and window.line.verdict.score is not None:
                self._alarming.append(window.line.verdict.score)
            self._groups.append(window.group or " ".join(record))
            self._blocks.append(" ".join((*record, str(int(comparable(window.line.start / self._duration))))))
            self._has_groups |= bool(window.group)

    @property
    def n_record(self) -> int:
        """Records, those among them that were rejected."""
        return len(self._records)

    @property
    def n_judged(self) -> int:
        """Windows that were judged."""
        return len(self._outcomes)

    @property
    def n_alarm(self) -> int:
        """Alarms."""
        return int(sum(self._outcomes))

    @property
    def hours(self) -> float:
        """Time that was judged [h]: of overlapping windows, what each adds."""
        return self.n_judged * self._every / 3600.0

    @property
    def noun(self) -> str:
        """What is judged."""
        return "estimate" if self._by_estimate else "window"

    @property
    def rests_on(self) -> str | None:
        """What the interval of the share takes as independent: ``groups`` or ``records``; ``windows`` that do
        not overlap if these are too few; None if nothing is, as estimates of a few records.
        """
        if self.n_group >= FEWEST_GROUPS:
            return self.group_noun
        return "windows" if self.n_judged and not self._by_estimate else None

    @property
    def n_group(self) -> int:
        """Groups of which something was judged; records if nobody stated groups."""
        return len(set(self._groups))

    @property
    def group_noun(self) -> str:
        """What they are: ``groups`` or ``records``."""
        return "groups" if self._has_groups else "records"

    @property
    def consequence(self) -> Consequence:
        """What the alarms come to; the flow is that of their median score."""
        score = float(np.median(self._alarming)) if self._alarming else None
        doubt = self.first_doubt if self.n_doubtful >= self.n_alarm else ""
        return consequence(self.file, self.n_judged, self.n_alarm, score, doubt=doubt)

    @property
    def rate(self) -> Rate:
        """The share of judged windows that are alarms, with its interval."""
        groups: list[str] | None = self._groups
        if self.rests_on == "windows":
            groups = self._blocks if self._every < self._duration else None
        return alarm_rate(self._outcomes, groups=groups, confidence=self.file.config.confidence)


_ROWS = 1_000
"""Windows in memory while a table is written."""


def windows_table(file: DetectorFile, windows: Sequence[JudgedWindow]) -> Table:
    """A row for each window, or record without any; people see alarms and scores beyond a limit in bold."""
    rows = [_fields(window, file) for window in windows]
    faults = [each.fault.kind for each in windows if each.fault and each.is_beyond and each.alarm is None]
    were = "window beyond the limit was" if len(faults) == 1 else "windows beyond the limit were"
    doubts, notes = [window.doubt for window in windows if window.doubt], list[str]()
    if faults:
        notes.append(f"{len(faults):,} {were} not judged: {', '.join(sorted(set(faults)))}")
    if doubts:
        notes.append(f"doubtful: {counted(len(doubts), 'window')}, such as {doubts[0]}")
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
            column("chart_statistic", title=chart, is_shown=file.chart is not None),
            Column("alarm", alarms, title="verdict", text=[*map(_verdict, windows)], is_text=True),
            *words("fault", "reason", "doubt"),
        ),
        title=f"{file.score_name}, {file.feature.meaning}: alarm {file.alarm_text}",
        notes=tuple(notes),
        row="window",
    )


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
