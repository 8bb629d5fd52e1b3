"""Records of any source → what a detector says of each window, and what all windows come to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import nan
from typing import Any

import numpy as np

from hydrofdi.detectors.trained.detector import Detector
from hydrofdi.detectors.trained.file import DetectorFile
from hydrofdi.detectors.trained.lines import WindowLine
from hydrofdi.detectors.trained.promise import Consequence, consequence
from hydrofdi.detectors.trained.verdicts import Leak, Verdict, without_scale
from hydrofdi.errors import Issue
from hydrofdi.evaluation.rates import Rate, alarm_rate
from hydrofdi.evaluation.roc import FEWEST_GROUPS
from hydrofdi.evaluation.scores import comparable
from hydrofdi.records import RecordBatch
from hydrofdi.records.streams import Chunk

_RATE = 0.01
"""Share of the sampling frequency that a record may differ."""

_SAID_OF_WINDOWS = ("missing", "stuck", "gap")
"""Remarks on whole records that windows have as faults of their own."""


@dataclass(frozen=True)
class JudgedWindow(WindowLine):
    """A window of a record, as the line of a monitor which is given the record as a stream by itself; or a
    record without any window, with a negative number and the reason as its fault. ``label``: condition of the
    record, where it is known.
    """

    record_id: str = ""
    source: str = ""
    group: str = ""
    label: str = ""


def judged_windows(detector: Detector, batch: RecordBatch) -> Iterator[JudgedWindow]:
    """Every window of records."""
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
        yield from (JudgedWindow(**vars(line), **named) for line in lines)
        if not lines:
            yield _without(fault or _without_windows(detector.file, batch), **named)


def _without(fault: Issue, **named: Any) -> JudgedWindow:
    """A record without any window."""
    return JudgedWindow(-1, nan, nan, Verdict(fault=fault), **named)


def _lines(detector: Detector, records: RecordBatch, row: int) -> list[WindowLine]:
    samples = {channel: values[row] for channel, values in records.channels.items()}
    _, found = detector.step(detector.start(), Chunk(records.time, samples))
    lines = [line for line in found if isinstance(line, WindowLine)]
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

    ``faults``: kind → windows, or records without any, that were not judged, ``n_beyond`` of them with a
    score beyond a limit all the same. ``n_doubtful`` judged ones, with the ``first_doubt``. ``unjudged``:
    source and record of those of which nothing was judged nor novel, which is a finding → the first reason.
    """

    def __init__(self, file: DetectorFile, windows: Iterable[JudgedWindow]) -> None:
        self.file = file
        self.faults: Counter[str] = Counter()
        self.n_beyond = self.n_doubtful = 0
        self.first_doubt = ""
        self.unjudged: dict[tuple[str, str], str] = {}
        self._windows = windows
        self._outcomes: list[float] = []
        self._alarming: list[Leak] = []
        self._groups: list[str] = []
        self._blocks: list[str] = []
        self._records: set[tuple[str, str]] = set()
        self._has_groups, frequency = False, file.sampling_frequency
        self._duration = file.n_sample / frequency
        self._every = min(file.n_every / frequency, self._duration)

    def __iter__(self) -> Iterator[JudgedWindow]:
        for window in self._windows:
            self._count(window)
            yield window

    def _count(self, window: JudgedWindow) -> None:
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
            self._outcomes.append(float(window.alarm))
            if window.alarm and verdict.leak is not None:
                self._alarming.append(verdict.leak)
            self._groups.append(window.group or " ".join(record))
            self._blocks.append(" ".join((*record, str(int(comparable(window.start / self._duration))))))
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
    def rests_on(self) -> str | None:
        """What the interval of the share takes as independent: ``groups`` or ``records``; ``windows`` that do
        not overlap if these are too few; None if nothing is judged.
        """
        if self.n_group >= FEWEST_GROUPS:
            return self.group_noun
        return "windows" if self.n_judged else None

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
        """What the alarms come to; the leak is their median."""
        leak = Leak(*np.median(self._alarming, axis=0).tolist()) if self._alarming else None
        return consequence(self.file, self.n_judged, self.n_alarm, leak)

    @property
    def rate(self) -> Rate:
        """The share of judged windows that are alarms, with its interval."""
        groups: list[str] | None = self._groups
        if self.rests_on == "windows":
            groups = self._blocks if self._every < self._duration else None
        return alarm_rate(self._outcomes, groups=groups, confidence=self.file.config.confidence)
