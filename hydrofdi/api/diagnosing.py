"""Which fault records show: hypotheses with probabilities, sizes, and what tells them apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from hydrofdi.api.arguments import Names, Texts, names_of
from hydrofdi.api.detectors.healthy_records import HealthyRecords, analysed_batches, experiment_of
from hydrofdi.api.measuring import assumed_plants, of_machine
from hydrofdi.api.simulated import SimulatedRecords
from hydrofdi.api.sources import Said, open_records
from hydrofdi.diagnosis.evidence import NAMED, Finding, Judge
from hydrofdi.diagnosis.history import (
    FEWEST,
    History,
    balance_of,
    history_of,
    history_of_sheet,
    signatures,
)
from hydrofdi.diagnosis.hypotheses import HEALTHY, REPAIRS
from hydrofdi.errors import ConfigError, DataError
from hydrofdi.indicators.balancing import P1, P2, BalanceOptions, X
from hydrofdi.indicators.selection import make_indicators
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.report.table import Column, Table
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import HOLE, number_text, percent, readable_unit, typeset
from hydrofdi.store.records import StoredRecords
from hydrofdi.units import convert

_PIECE, _SHORTEST = 20.0, 10.0
"""Length into which longer records are cut, and least length of a record [s]."""

_HIDDEN = ("low", "high", "size_low", "size_high")
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
        return tuple(each for each in self.findings if each.probability >= NAMED)


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
    def table(self) -> Table:
        """A row for each record and named hypothesis, the most probable first.

        ``record``, ``name``, its ``title``, ``probability`` with ``low`` and ``high``, and ``size`` with
        ``size_low`` and ``size_high`` in SI.
        """
        rows = [(record, each) for record in self.records for each in record.named]
        findings = [each for _, each in rows]
        shown = [_size_text(each) for each in findings]
        likelihoods = [
            "above 99.9 %" if p > 0.999 else percent(p) for p in (each.probability for each in findings)
        ]
        texts = {
            "record": [record.record_id for record, _ in rows],
            "name": [each.name for each in findings],
            "title": [each.title for each in findings],
        }
        numbers = {
            name: [getattr(each, name) for each in findings] for name in ("probability", "size", *_HIDDEN)
        }
        return Table((
            Column("record", texts["record"], is_text=True, is_shown=len(self.records) > 1),
            Column("title", texts["title"], title="fault", is_text=True),
            Column("probability", numbers["probability"], title="probability", text=likelihoods),
            Column("size", numbers["size"], title="size", text=shown),
            Column("name", texts["name"], is_text=True, is_shown=False),
            *(Column(each, numbers[each], is_shown=False) for each in _HIDDEN),
        ), row="hypothesis")  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as ``hydrofdi diagnose --json`` prints it."""

        def plain(value: Any) -> Any:
            return None if isinstance(value, float) and not math.isfinite(value) else value

        records = [
            {
                "record_id": record.record_id,
                "name": record.name or None,
                "reason": record.reason or None,
                "findings": [{key: plain(v) for key, v in asdict(each).items()} for each in record.findings],
            }
            for record in self.records
        ]
        return {
            "sensors": self.sensors,
            "healthy_records": self.n_healthy,
            "records": records,
            "remarks": [*self.remarks],
        }


def diagnose(
    data: Any,
    history: Any = None,
    *,
    healthy: str | int | Sequence[str | int] = (),
    options: Mapping[str, Any] | None = None,
    sampling_frequency: str | float | None = None,
    channel: Names = None,
    unit: Names = None,
    label: Texts = None,
) -> Diagnosis:
    """Name the fault that records of a machine show, or say that nothing is wrong.

    Parameters
    ----------
    data : path, results, array_like, mapping, DataFrame, Dataset, or list of these
        Records with P1, x, and u or the spool position; better with P2. As for `hydrofdi.measure`. Of
        labelled records, those that are not healthy. All records are cut into pieces of 20 s, or of the
        shortest record of 10 s or more.
    history : same, optional
        Healthy records of the same machine, at least three, better twelve, of other days. By default the
        healthy ones of labelled records; if there are none, the data sheet takes their place.
    healthy : str, int, or sequence of them, optional
        Labels of healthy records, besides those that descriptions name.
    options : mapping, optional
        Options of the indicator ``flow_balance``, such as ``{"half_window": 8}``.
    sampling_frequency, channel, unit, label : optional
        As for `hydrofdi.measure`.

    Returns
    -------
    Diagnosis

    Raises
    ------
    ConfigError, DataError
        An argument is invalid, or channels are missing.
    """
    said = Said(sampling_frequency, channel, unit)
    sources = open_records(data, tuple(Channel), replace(said, label=label))
    is_own, names = history is None, tuple(names_of("healthy", healthy, "labels of healthy records"))
    history_sources = sources if is_own else open_records(history, tuple(Channel), said)
    for source in (*sources, *history_sources):
        if isinstance(source, SimulatedRecords | StoredRecords) and experiment_of(source).study is not None:
            text = "a study draws another machine for each record; diagnose records of one machine"
            raise ConfigError(f"{source.name}: {text}")
    known = HealthyRecords(history_sources, names)
    if is_own and known.is_unlabelled:
        past, asked = list[RecordBatch](), _batches(sources)
    else:
        past = [*known.batches()]
        asked = [*HealthyRecords(sources, names, is_faulty=True).batches()] if is_own else _batches(sources)
    if not asked:
        raise ConfigError(f"{known.name}: all records are healthy; there is none to diagnose")
    return _diagnosed(past, asked, [*sources, *([] if is_own else history_sources)], options or {})


def _batches(sources: Sequence[RecordSource]) -> list[RecordBatch]:
    return [batch for source in sources for batch in analysed_batches(source)]


def _diagnosed(
    past: Sequence[RecordBatch],
    asked: Sequence[RecordBatch],
    sources: Sequence[RecordSource],
    options: Mapping[str, Any],
) -> Diagnosis:
    n_day = sum(each.n_record for each in past)
    rejected = tuple(
        RecordDiagnosis(each.record_id, reason=each.remark.message)
        for batch in asked
        for each in batch.rejected
    )
    whole = [each for each in (*past, *asked) if each.n_record]
    if not whole:
        reason = rejected[0].reason if rejected else "no record"
        raise DataError(f"{sources[0].name}: {reason}")
    length = min([_PIECE, *(each.duration for each in whole if each.duration >= _SHORTEST)])
    past, used = ([piece for each in of for piece in _pieces(each, length)] for of in (past, whole))
    shared = set.intersection(*({*each.channels} - each.relative for each in whole))
    settings = _settings(shared, sources[0].name) | dict(options)
    made = of_machine(make_indicators({"flow_balance": settings}), sources)
    chosen = made["flow_balance"].options
    past = [
        batch.rows([row for row in range(batch.n_record) if not _obstacle(batch.rows([row]), chosen, shared)])
        for batch in past
    ]
    if len(rates := {batch.sampling_frequency for batch in past if batch.n_record}) > 1:
        found = " and ".join(f"{each:g}" for each in sorted(rates))
        raise DataError(f"the history has records of {found} Hz; resample them to one rate")
    n_past, remarks = sum(each.n_record for each in past), [*assumed_plants(made)]
    if n_past < FEWEST:
        found = f"{counted(n_past, 'healthy record')}; " if n_past else ""
        remarks.append(
            f"{found}the data sheet takes the place of a history: small faults and valves that differ from it"
            f" look alike; at least {FEWEST} healthy records of this machine tell more (--history)"
        )
    elif n_day < FEWEST:
        remarks.append(
            f"the history is cut from {counted(n_day, 'record')}: what differs from day to day, as oil"
            " temperature does, may look like a fault"
        )
    if P2 not in shared:
        remarks.append("with P1 alone, leaks, valve and supply look alike: take the names as hints")
    known = [each for each in past if each.n_record] if n_past >= FEWEST else used
    judge = None
    if n_past >= FEWEST:
        judge = Judge(history_of(known, balance_of(known, chosen)))
    records = [
        record
        for batch in asked
        for piece in _pieces(batch, length)
        for record in _records(piece, chosen, shared, known, judge)
    ]
    sensors = " ".join(each.symbol for each in Channel if each in _channels_of(shared))
    return Diagnosis((*records, *rejected), sensors, n_past if judge else 0, tuple(remarks))


def _pieces(batch: RecordBatch, length: float) -> Iterator[RecordBatch]:
    """Records of one length [s]: longer ones are cut, and named by their time; short ones are as they are."""
    n_time, n_piece = round(length * batch.sampling_frequency), max(1, int(batch.duration / length * 1.0001))
    for first in range(0, n_piece * n_time, n_time):
        piece = batch.window(first, first + n_time)
        ends = f" {piece.start_time:.0f}–{piece.start_time + piece.duration:.0f} s" if n_piece > 1 else ""
        yield replace(piece, record_ids=tuple(f"{each}{ends}" for each in batch.record_ids), rejected=())


def _obstacle(one: RecordBatch, options: BalanceOptions, shared: set[Channel]) -> str:
    """Why a record tells nothing of the machine; empty if it does."""
    if one.duration < _SHORTEST:
        return f"it lasts {one.duration:.3g} s; {_SHORTEST:g} s are needed"
    n_missing = int(sum(np.sum(~np.isfinite(one[each])) for each in _channels_of(shared)))
    if n_missing:
        return f"{n_missing:,} samples are missing ('hydrofdi measure' shows where)"
    return options.lack_of_windows(one) or options.unfit_positions(one)[0] or ""


def _records(
    batch: RecordBatch,
    options: BalanceOptions,
    shared: set[Channel],
    known: Sequence[RecordBatch],
    judge: Judge | None,
) -> Iterator[RecordDiagnosis]:
    """The diagnosis of each record, compared with known ones, or with the data sheet."""
    spans = np.concatenate([_travel(each, options) for each in known])
    for row in range(batch.n_record):
        one = batch.rows([row])
        reason, rate = _obstacle(one, options, shared), known[0].sampling_frequency
        if not reason and judge is not None and abs(one.sampling_frequency / rate - 1.0) > 0.01:
            reason = f"it has {one.sampling_frequency:g} Hz, the history {rate:g} Hz; resample one of them"
        if not reason and judge is not None:
            ends = np.maximum([spans.min(axis=0), spans.max(axis=0)], 1e-9)
            shares = _travel(one, options)[0] / ends
            if np.any(shares[0] < 0.5) or np.any(shares[1] > 2.0):
                way, speed = (percent(low if low < 1.0 else high) for low, high in shares.T)
                reason = (
                    f"the piston moves otherwise than in the history: {way} of its way, {speed} of its speed"
                )
        if reason:
            yield RecordDiagnosis(one.record_ids[0], reason=reason)
            continue
        own = judge or Judge(history_of_sheet(one, balance_of([one], options)))
        yield RecordDiagnosis(one.record_ids[0], tuple(_judged(one, own)))


def _travel(batch: RecordBatch, options: BalanceOptions) -> Array:
    """Way of the piston [m], and deviation of its steps over a twentieth of a second [m], (n_record, 2)."""
    position = options.position(batch)
    behind = max(1, round(0.05 * batch.sampling_frequency))
    way = np.diff(np.quantile(position, (0.02, 0.98), axis=1), axis=0)[0]
    return np.stack((way, np.std(position[:, behind:] - position[:, :-behind], axis=1)), axis=1)


def _channels_of(shared: set[Channel]) -> set[Channel]:
    """Those of some channels that the balance uses."""
    return shared & {P1, P2, X, SUPPLY} | ({SPOOL} if SPOOL in shared else shared & {U})


def _settings(shared: set[Channel], name: str) -> dict[str, Any]:
    """How valve, supply and second pressure are known from some channels."""
    missing = [each.symbol for each in (P1, X) if each not in shared]
    if not shared & {U, SPOOL}:
        missing.append("u or xv")
    if missing:
        raise DataError(f"{name}: diagnose needs P1, x, and u or xv; missing: {', '.join(missing)}")
    return {
        "spool": "measured" if SPOOL in shared else "command",
        "supply": "measured" if SUPPLY in shared else "nominal",
        "chambers": "both" if P2 in shared else 1,
    }


def _judged(record: RecordBatch, judge: Judge) -> list[Finding]:
    history = judge.history

    def signature(of: RecordBatch) -> tuple[Any, Any]:
        found, estimates = signatures(history.balance, of, history.variance)
        return found[0], estimates

    own, estimates = signature(record)
    gain, covariance = estimates.gains[0], estimates.covariances[0]
    findings = judge.judge(own, gain, covariance)
    if findings[0].name == HEALTHY:
        return findings
    # A recording that is wired wrongly is undone exactly; only then is it worth the time.
    repaired = {name: signature(each)[0] for name, each in _repaired(record, history)}
    return judge.judge(own, gain, covariance, repaired)


def _repaired(record: RecordBatch, history: History) -> Iterator[tuple[str, RecordBatch]]:
    """The record as it would be without each fault of the recording."""
    channels = dict(record.channels)
    changes: dict[str, dict[Channel, Any]] = {}
    if history.balance.both:
        changes["swapped_pressures"] = {P1: channels[P2], P2: channels[P1]}
    drive = SPOOL if history.balance.options.spool == "measured" else U
    changes["wrong_sign_u"] = {drive: -channels[drive]}
    if history.balance.options.position_zero == "centre":
        changes["wrong_sign_x"] = {X: -channels[X]}
    for name in REPAIRS:
        if name in changes:
            yield name, replace(record, channels=channels | changes[name])


def _size_text(finding: Finding) -> str:
    if not math.isfinite(finding.size):
        return HOLE
    unit = "%" if finding.unit == "1" else readable_unit(finding.unit, finding.size_high)
    low, size, high = (
        number_text(convert(each, unit), 2) for each in (finding.size_low, finding.size, finding.size_high)
    )
    return f"{size} {typeset(unit)} ({low}–{high})"
