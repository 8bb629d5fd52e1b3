"""Histories of a score over days: from logs of a monitor, or from measured records with dates."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.errors import DataError
from hydrofdi.evaluation.change_point import FEWEST
from hydrofdi.evaluation.scores import comparable
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.source import MeasuredSource
from hydrofdi.records.times import FIRST_DATE
from hydrofdi.settings.messages import counted, time_text

DAY = 86400.0
"""A day [s]."""

_LINE = b'{"line":'
_HEAD = 1 << 20
"""Bytes at the beginning of a log among which a line begins."""

_P1, _P2, _X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION

_Row = tuple[float, float, float, str]
"""End [s], score, oil temperature [K], and digest of the detector, of a window; empty if it is not known."""

_MOST_POINTS = 400
"""Most points; more are joined."""
_FEW = 0.1
"""Share of the usual number of scores below which a point is left out."""


@dataclass(frozen=True, eq=False)
class History:
    """Scores over time.

    Attributes
    ----------
    name, meaning : str
        Where they are from, and what the score is.
    unit : str
        SI unit of the score.
    time : ndarray, shape (n,)
        Increasing [s]; since 1970 if it is dated.
    score, temperature : ndarray, shape (n,)
        Score, and oil temperature [K], NaN if it is not known.
    remarks : tuple of str
        What has to be known of the scores.
    """

    name: str
    meaning: str
    unit: str
    time: Array
    score: Array
    temperature: Array
    remarks: tuple[str, ...] = ()

    @property
    def is_dated(self) -> bool:
        """Whether the clock counts from 1970."""
        return bool(self.time[0] >= FIRST_DATE)


@dataclass(frozen=True, eq=False)
class SpanMedians:
    """Medians of the scores of equal spans of time.

    Attributes
    ----------
    time, score, temperature : ndarray, shape (n,)
        [s], unit of the score, [K].
    n_score : ndarray, shape (n,)
    is_used : ndarray, shape (n,)
        False for outliers, and for points without oil temperature if that is compensated.
    """

    time: Array
    score: Array
    temperature: Array
    n_score: NDArray[np.int64]
    is_used: NDArray[np.bool_]


def points_of(history: History, span: float) -> tuple[SpanMedians, float, list[str]]:
    """Points of a history, their span [s], which may be longer than asked for, and remarks."""
    remarks = list[str]()
    n_most = np.unique(np.floor(comparable(history.time / span))).size
    if n_most > _MOST_POINTS:
        span *= math.ceil(n_most / _MOST_POINTS)
        remarks.append(f"points of {time_or_days(span)}, because there would be more than {_MOST_POINTS}")
    starts = np.flatnonzero(np.diff(np.floor(comparable(history.time / span)), prepend=-np.inf))
    parts = [slice(*ends) for ends in pairwise([*starts.tolist(), history.time.size])]
    counts = np.array([part.stop - part.start for part in parts])
    parts = [part for part, n in zip(parts, counts, strict=True) if n >= _FEW * np.median(counts)]
    if len(parts) < counts.size:
        remarks.append(f"left out: {counted(counts.size - len(parts), 'point')} of few scores")
    warm = [history.temperature[part] for part in parts]
    points = SpanMedians(
        np.array([np.median(history.time[part]) for part in parts]),
        np.array([np.median(history.score[part]) for part in parts]),
        np.array([np.mean(part[np.isfinite(part)]) if np.isfinite(part).any() else np.nan for part in warm]),
        np.array([part.stop - part.start for part in parts]),
        np.ones(len(parts), dtype=bool),
    )
    return points, span, remarks


def instant_text(time: float) -> str:
    """An instant for display, a date if it counts from 1970."""
    is_dated = time >= FIRST_DATE
    return f"{datetime.fromtimestamp(time, UTC):%Y-%m-%d %H:%M}" if is_dated else time_text(time)


def time_or_days(seconds: float) -> str:
    """A duration for display."""
    days = seconds / DAY
    return counted(round(days), "day") if days >= 0.995 else time_text(seconds)


@dataclass(frozen=True)
class MeasuredScore:
    """What is measured of records: its name, the unit that it has in a batch, and its values in one."""

    label: str
    unit: Callable[[RecordBatch], str]
    values: Callable[[RecordBatch], Array]


def logged_histories(data: Any) -> dict[str, History] | None:
    """Machine → its history in logs of a monitor, or in the lines of one; a single one has no name.

    None if the data are others. Raises DataError if something cannot be read, or no window has a score.
    """
    several = data if isinstance(data, list | tuple) else [data]
    paths = [Path(each).expanduser() for each in several if isinstance(each, str | Path)]
    if paths and all(map(_is_log, paths)):
        name = ", ".join(map(str, paths))
        return _of_lines((line for path in paths for line in _lines(path)), name)
    if several and all(isinstance(each, Mapping) and "line" in each for each in several):
        return _of_lines(((f"line {n}", each) for n, each in enumerate(several, 1)), "the lines")
    return None


def _is_log(path: Path) -> bool:
    if not path.is_file():
        return False
    with open(path, "rb") as file:
        return any(line.startswith(_LINE) for line in file.read(_HEAD).split(b"\n"))


def _lines(path: Path) -> Iterator[tuple[str, Any]]:
    """Place and content of each line; None if it is damaged. A last one that is being written is left out."""
    with open(path, "rb") as file:
        for number, text in enumerate(file, 1):
            try:
                content = json.loads(text)
            except (ValueError, RecursionError):
                content = None
            if text.endswith(b"\n"):
                yield f"{path}:{number}", content


def _of_lines(lines: Iterable[tuple[str, Any]], name: str) -> dict[str, History]:
    """Windows that have a score, also those that are novel: a large leak may be."""
    rows, damaged, units = dict[str, list[_Row]](), list[str](), dict[tuple[str, str], str]()
    for place, line in lines:
        try:
            if line["line"] != "window" or line["score"] is None:
                continue
            machine, digest = (str(line.get(key) or "") for key in ("machine", "digest"))
            unit, warm = str(line["unit"]), line.get(Channel.OIL_TEMPERATURE)
            scored = float(line["end"]), float(line["score"])
            row = (*scored, math.nan if warm is None else float(warm), digest)
        except (LookupError, TypeError, ValueError, AttributeError):
            damaged.append(place)
            continue
        if not all(map(math.isfinite, scored)):
            damaged.append(place)
            continue
        if (other := units.setdefault((machine, digest), unit)) != unit:
            raise DataError(f"{place}: window {line.get('number')}: is in {unit}, but others in {other}")
        before = rows.setdefault(machine, [])
        if before and row[0] < before[-1][0] and row[0] < FIRST_DATE:
            raise DataError(
                f"{place}: window {line.get('number')}: the clock goes from {before[-1][0]:.10g} s to"
                f" {row[0]:.10g} s; trends need samples with dates (docs/monitoring-sources.md), or one log"
                " for each start"
            )
        before.append(row)
    remarks = [f"left out: {counted(len(damaged), 'damaged line')}, such as {damaged[0]}"] if damaged else []
    if not rows:
        raise DataError("; ".join([f"{name}: no window has a score", *remarks]))
    return {
        machine: _since_its_detector(
            f"{machine} of {name}" if machine else name, own, units, machine, remarks
        )
        for machine, own in rows.items()
    }


def _since_its_detector(
    name: str, rows: list[_Row], units: Mapping[tuple[str, str], str], machine: str, remarks: Sequence[str]
) -> History:
    """The windows of the last detector: another one has other scores or limits."""
    rows, first, digest = sorted({*rows}), 0, ""
    for index, row in enumerate(rows):
        first = index if digest and row[3] not in ("", digest) else first
        digest = row[3] or digest
    if first:
        since = instant_text(rows[first][0])
        left = f"left out: {counted(first, 'window')} of another detector; this one judges since {since}"
        remarks = [*remarks, left]
    time, score, temperature = np.array([row[:3] for row in rows[first:]]).T
    return History(name, "score", units[machine, rows[-1][3]], time, score, temperature, tuple(remarks))


def require_files(sources: Sequence[RecordSource]) -> None:
    """Check that measured files can be points enough before any is read."""
    if all(isinstance(each, MeasuredSource) and each.files and not each.config.cycles for each in sources):
        n_most = sum(len(each.files) for each in sources if isinstance(each, MeasuredSource))
        if n_most < FEWEST:
            raise DataError(
                f"{_name_of(sources)}: has {counted(n_most, 'file')}; a trend needs {FEWEST} points or more"
            )


def history_of_records(
    sources: Sequence[RecordSource],
    score: MeasuredScore,
    assumptions: Sequence[str],
    accept: Callable[[str, bool], object],
) -> History:
    """The history of a score in records with dates.

    Unit and whether they have dates are handed to `accept` before the first is measured.
    """
    name = _name_of(sources)
    rows, remarks, unit = list[tuple[float, float, float]](), [*assumptions], ""
    n_record = n_undated = 0
    for batch in (batch for source in sources for batch in source.batches() if batch.n_record):
        if not unit:
            if math.isnan(batch.dates[0]):
                raise DataError(
                    f"{batch.record_ids[0]}: has no date; use a time column of dates, or take it from the"
                    ' name of the file: path: "press {date}.csv", date: "{date}" (docs/measured.md)'
                )
            unit = score.unit(batch)
            accept(unit, batch.dates[0] >= FIRST_DATE)
        n_record += batch.n_record
        n_undated += sum(map(math.isnan, batch.dates))
        scores = score.values(batch)
        own_warm = Channel.OIL_TEMPERATURE in batch.channels
        warm = batch[Channel.OIL_TEMPERATURE].mean(axis=1) if own_warm else np.full(batch.n_record, np.nan)
        whole = zip(batch.dates, scores.tolist(), warm.tolist(), strict=True)
        rows += [row for row in whole if math.isfinite(row[0]) and math.isfinite(row[1])]
    if not rows:
        raise DataError(f"{name}: {score.label} measures none of {counted(n_record, 'record')}")
    if n_undated:
        remarks.append(f"left out: {n_undated:,} of {n_record:,} records without a date")
    if (n_empty := n_record - n_undated - len(rows)) > 0:
        remarks.append(f"{score.label} has no number in {n_empty:,} of {n_record:,} records")
    time, values, temperature = np.array(sorted(rows)).T
    return History(name, score.label, unit, time, values, temperature, tuple(remarks))


def _name_of(sources: Sequence[RecordSource]) -> str:
    return ", ".join(source.name for source in sources)


def balance_of(sources: Sequence[RecordSource]) -> dict[str, Any]:
    """The balance that needs no more than the sensors of the first records, with its options."""
    first = next((batch for source in sources for batch in source.batches() if batch.n_record), None)
    known = set() if first is None else first.channels.keys() - first.relative
    spool = "measured" if Channel.SPOOL_POSITION in known else "command"
    if _P1 not in known or not known & {Channel.SPOOL_POSITION, Channel.INPUT_VOLTAGE}:
        raise DataError(
            f"{_name_of(sources)}: a balance needs P1, and u or xv, in SI; state what to measure with"
            " 'indicator'"
        )
    options = {"spool": spool} | ({} if _P2 in known else {"chambers": 1})
    return {"flow_balance" if _X in known else "pressure_balance": options}
