"""Diagnosis of opened records: their pieces, which of them can be judged, the findings and the answer."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.diagnosis.history import FEWEST, history_of, history_of_sheet
from hydrofdi.diagnosis.judging import NAMED, Finding, Judge
from hydrofdi.errors import DataError
from hydrofdi.indicators.balancing import P1, P2, X
from hydrofdi.indicators.catalogue.balances import BalanceOptions
from hydrofdi.indicators.selection import assumed_plants, make_indicators, of_machine
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.copies import Copies, pairs, sketch_of
from hydrofdi.settings.messages import (
    HOLE,
    convert,
    counted,
    number_text,
    percent,
    readable_unit,
    shown_quantity,
    typeset,
)
from hydrofdi.tables.table import Column, Table, plain

_PIECE, _SHORTEST = 20.0, 10.0
"""Length into which longer records are cut, and least length of a record [s]."""

_MANY = 6
"""Fewest healthy records among which one is looked for that is unlike the others."""

_IMPLAUSIBLE = ("spike", "unusual", "low_pressure")
"""Kinds of remarks on records whose numbers are not those of a machine."""

_NOTHING_SEEN = (
    "most faults could not be seen at any size: the model explains too little of this machine, or numbers are"
    " not finite ('hydrofdi measure' states the misfit of flow_balance)"
)

_HIDDEN = ("low", "high", "size_low", "size_high", "visible")
"""Numbers of a finding that only programs see in the table."""

U, SPOOL, SUPPLY = Channel.INPUT_VOLTAGE, Channel.SPOOL_POSITION, Channel.SUPPLY_PRESSURE


@dataclass(frozen=True)
class RecordDiagnosis:
    """Findings on a record, the most probable first; why there are none, if it could not be judged."""

    record_id: str
    findings: tuple[Finding, ...] = ()
    reason: str = ""

    @property
    def name(self) -> str:
        """Name of the most probable hypothesis; empty if it could not be judged."""
        return self.findings[0].name if self.findings else ""

    @property
    def named(self) -> tuple[Finding, ...]:
        """The first finding, and others with a probability of at least 1 %."""
        return tuple(finding for finding in self.findings if finding.probability >= NAMED)


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Which fault each record shows, as `hydrofdi.diagnose` returns it.

    Attributes
    ----------
    records : tuple of RecordDiagnosis
    sensors : str
        Channels that were used, such as ``P1 P2 x u``.
    n_healthy : int
        Healthy records of the same machine that the history rests on; 0 if it rests on the data sheet.
    remarks : tuple of str
        What limits the answer.
    """

    records: tuple[RecordDiagnosis, ...]
    sensors: str
    n_healthy: int
    remarks: tuple[str, ...] = ()

    @property
    def counts(self) -> dict[str, int]:
        """Name of the most probable hypothesis → number of records; the most frequent first."""
        return dict(Counter(record.name for record in self.records if record.name).most_common())

    @property
    def table(self) -> Table:
        """A row for each record and named hypothesis, the most probable first.

        ``record``, ``name``, its ``title``, ``probability`` with ``low`` and ``high``; in SI ``size`` with
        ``size_low`` and ``size_high``, and the size from which on the fault is ``visible``.
        """
        rows = [(record.record_id, finding) for record in self.records for finding in record.named]
        findings = [finding for _, finding in rows]
        values = {
            name: [getattr(finding, name) for finding in findings]
            for name in ("title", "probability", "size", "name", *_HIDDEN)
        }
        likelihoods = ["above 99.9 %" if p > 0.999 else percent(p) for p in values["probability"]]
        shown, names = [_size_text(finding) for finding in findings], [name for name, _ in rows]
        return Table((
            Column("record", names, is_text=True, is_shown=len(self.records) > 1),
            Column("title", values["title"], title="fault", is_text=True),
            Column("probability", values["probability"], title="probability", text=likelihoods),
            Column("size", values["size"], title="size", text=shown),
            Column("name", values["name"], is_text=True, is_shown=False),
            *(Column(name, values[name], is_shown=False) for name in _HIDDEN),
        ), row="hypothesis")  # fmt: skip

    def visible_text(self, record: RecordDiagnosis) -> str:
        """Which faults would have been seen from which size on, and which at no size."""
        sized = sorted(
            (each.title, each.visible, each) for each in record.findings if not math.isnan(each.visible)
        )
        seen = [
            f"{title} {shown_quantity(size, each.unit, '%' if each.unit == '1' else '', 2)}"
            for title, size, each in sized
            if math.isfinite(size)
        ]
        never = [title for title, size, _ in sized if math.isinf(size)]
        return f"{'; '.join(seen)}." + (f" At no size: {'; '.join(never)}." if never else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as ``hydrofdi diagnose --json`` prints it."""
        records = [
            {
                "record_id": record.record_id,
                "name": record.name or None,
                "reason": record.reason or None,
                "findings": plain(record.findings),
            }
            for record in self.records
        ]
        return {
            "sensors": self.sensors,
            "healthy_records": self.n_healthy,
            "counts": self.counts,
            "records": records,
            "remarks": [*self.remarks],
        }


def diagnose(
    asked: Sequence[RecordBatch],
    healthy: Sequence[RecordBatch],
    sources: Sequence[RecordSource],
    options: Mapping[str, Any],
) -> Diagnosis:
    """Name the faults that records show.

    Parameters
    ----------
    asked, healthy : sequence of RecordBatch
        What is diagnosed, and the history of the same machine. Longer records are cut into pieces of 20 s,
        or of the shortest record of 10 s or more.
    sources : sequence of RecordSource
        Where the records are from; their data sheets describe the machine.
    options : mapping
        Options of the indicator ``flow_balance``.

    Raises
    ------
    ConfigError, DataError
        An option is invalid, the sources are of different machines, or channels are missing.
    """
    rejected = tuple(
        RecordDiagnosis(each.record_id, reason=each.remark.message)
        for batch in asked
        for each in batch.rejected
    )
    whole = [batch for batch in (*healthy, *asked) if batch.n_record]
    if not whole:
        reason = rejected[0].reason if rejected else "no record"
        raise DataError(f"{sources[0].name}: {reason}")
    length = min([_PIECE, *(batch.duration for batch in whole if batch.duration >= _SHORTEST)])
    shared = set.intersection(*({*batch.channels} - batch.relative for batch in whole))
    settings = _settings(shared, sources[0].name) | dict(options)
    made = of_machine(make_indicators({"flow_balance": settings}), sources)
    chosen, used = made["flow_balance"].options, _channels_of(shared)
    pieces = [
        piece.rows([row])
        for batch in asked
        for piece in _pieces(batch, length)
        for row in range(piece.n_record)
    ]
    under_test, past, same = Copies(), list[RecordBatch](), list[str]()
    tested = [piece.record_ids[0] for piece in pieces if under_test.find(sketch_of(piece, 0)) is None]
    for piece in (piece for batch in healthy for piece in _pieces(batch, length)):
        rows = [row for row in range(piece.n_record) if not _obstacle(piece.rows([row]), chosen, used)]
        copied = {row: under_test.known(sketch_of(piece, row)) for row in rows}
        same += [f"{piece.record_ids[row]} is {tested[n]}" for row, n in copied.items() if n is not None]
        other = [row for row in rows if copied[row] is None]
        if other:
            past.append(piece.rows(other))
    if len(rates := {batch.sampling_frequency for batch in past}) > 1:
        stated = " and ".join(f"{rate:g}" for rate in sorted(rates))
        raise DataError(f"the history has records of {stated} Hz; resample them to one rate")
    n_past, n_day = (sum(batch.n_record for batch in of) for of in (past, healthy))
    history = past if n_past >= FEWEST else []
    remarks = [*assumed_plants(made)]
    if same:
        n_same = counted(len(same), "record")
        remarks.append(f"left out of the history: {n_same} that are under test: {pairs(same)}")
    judge = Judge(history_of(history, chosen)) if history else None
    names = [record_id for piece in history for record_id in piece.record_ids]
    while judge and judge.history.n_record >= _MANY and (strange := judge.stranger()):
        row, judge, finding = strange
        remarks.append(
            f"left out of the history: {names.pop(row)}, which is unlike the others ({finding.title},"
            f" {percent(finding.probability)})"
        )
    spans = [_travel(piece, chosen) for piece in history]
    records = []
    for one in pieces:
        reason, findings = _obstacle(one, chosen, used), list[Finding]()
        if history and not reason:
            reason = _difference(one, chosen, history[0].sampling_frequency, spans)
        if not reason:
            findings = (judge or Judge(history_of_sheet(one, chosen))).findings(one)
            reason = "" if findings else _NOTHING_SEEN
        records.append(RecordDiagnosis(one.record_ids[0], tuple(findings), reason))
    if not history:
        known = f"{counted(n_past, 'healthy record')}; " if n_past else ""
        remarks.append(
            f"{known}the data sheet takes the place of a history: small faults and valves that differ from it"
            f" look alike; at least {FEWEST} healthy records of this machine tell more (--history)"
        )
    elif n_day < FEWEST:
        remarks.append(
            f"the history is cut from {counted(n_day, 'record')}: what differs from day to day, as oil"
            " temperature does, may look like a fault"
        )
    if P2 not in shared:
        remarks.append("with P1 alone, leaks, valve and supply look alike: take the names as hints")
    sensors = " ".join(channel.symbol for channel in Channel if channel in used)
    return Diagnosis((*records, *rejected), sensors, len(names), tuple(remarks))


def _pieces(batch: RecordBatch, length: float) -> Iterator[RecordBatch]:
    """Records of one length [s]: longer ones are cut, and named by their time; short ones are as they are."""
    n_time, n_piece = round(length * batch.sampling_frequency), max(1, int(batch.duration / length * 1.0001))
    for first in range(0, n_piece * n_time, n_time):
        piece = batch.window(first, first + n_time)
        ends = f" {piece.start_time:.0f}–{piece.start_time + piece.duration:.0f} s" if n_piece > 1 else ""
        yield replace(piece, record_ids=tuple(f"{name}{ends}" for name in batch.record_ids), rejected=())


def _settings(shared: set[Channel], name: str) -> dict[str, Any]:
    """How valve, supply and second pressure are known from some channels."""
    missing = [channel.symbol for channel in (P1, X) if channel not in shared]
    if not shared & {U, SPOOL}:
        missing.append("u or xv")
    if missing:
        raise DataError(f"{name}: diagnose needs P1, x, and u or xv; missing: {', '.join(missing)}")
    return {
        "spool": "measured" if SPOOL in shared else "command",
        "supply": "measured" if SUPPLY in shared else "nominal",
        "chambers": "both" if P2 in shared else 1,
    }


def _channels_of(shared: set[Channel]) -> set[Channel]:
    """Those of some channels that the balance uses."""
    return shared & {P1, P2, X, SUPPLY} | ({SPOOL} if SPOOL in shared else shared & {U})


def _obstacle(one: RecordBatch, options: BalanceOptions, used: set[Channel]) -> str:
    """Why a record tells nothing of the machine; empty if it does."""
    if one.duration < _SHORTEST:
        return f"it lasts {one.duration:.3g} s; {_SHORTEST:g} s are needed"
    n_missing = int(sum(np.sum(~np.isfinite(one[channel])) for channel in used))
    if n_missing:
        return f"{n_missing:,} samples are missing ('hydrofdi measure' shows where)"
    for remark in one.remarks[0] if one.remarks else ():
        if remark.kind in _IMPLAUSIBLE:
            return remark.message
    return options.lack_of_windows(one) or options.unfit_positions(one)[0] or ""


def _difference(one: RecordBatch, options: BalanceOptions, rate: float, spans: Sequence[Array]) -> str:
    """Why a record cannot be compared with a history of this rate [Hz] and travel; empty if it can."""
    if abs(one.sampling_frequency / rate - 1.0) > 0.01:
        return f"it has {one.sampling_frequency:g} Hz, the history {rate:g} Hz; resample one of them"
    all_ = np.concatenate(spans)
    shares = _travel(one, options)[0] / np.maximum([all_.min(axis=0), all_.max(axis=0)], 1e-9)
    if not (np.any(shares[0] < 0.5) or np.any(shares[1] > 2.0)):
        return ""
    way, speed = (percent(low if low < 1.0 else high) for low, high in shares.T)
    return f"the piston moves otherwise than in the history: {way} of its way, {speed} of its speed"


def _travel(batch: RecordBatch, options: BalanceOptions) -> Array:
    """Way of the piston [m], and deviation of its steps over a twentieth of a second [m], (n_record, 2)."""
    position = options.position(batch)
    behind = max(1, round(0.05 * batch.sampling_frequency))
    way = np.diff(np.quantile(position, (0.02, 0.98), axis=1), axis=0)[0]
    return np.stack((way, np.std(position[:, behind:] - position[:, :-behind], axis=1)), axis=1)


def _size_text(finding: Finding) -> str:
    if not math.isfinite(finding.size):
        return HOLE
    unit = "%" if finding.unit == "1" else readable_unit(finding.unit, finding.size_high)
    sizes = finding.size_low, finding.size, finding.size_high
    low, size, high = (number_text(convert(each, unit, finding.unit), 2) for each in sizes)
    return f"{size} {typeset(unit)} ({low}–{high})"
