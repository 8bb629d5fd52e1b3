"""Measurement of indicators: for a batch of records, and for each record of several sources."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import prod
from time import process_time
from typing import Any

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.faults import FaultyIndicatorError, doubts_of, fault_of_outputs, raised
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.copies import Sketch, sketch_of
from hydrofdi.settings.messages import counted

Indicators = Mapping[str, Indicator[Any]]
"""Label → indicator."""

Seconds = dict[str, float]
"""Label of an indicator → its CPU time [s]."""


@dataclass(frozen=True)
class Measures:
    """Results of indicators for a batch.

    Attributes
    ----------
    values : dict of str to ndarray, shape (n_record, *dims)
        ``label.output`` → values; NaN if there are none.
    obstacles : dict of str to tuple of (str or None), length n_record
        Label → why a record has no values; None if it has any.
    faults : dict of str to str
        Label → error of an indicator that failed; it is the obstacle of all records.
    """

    values: dict[str, Array]
    obstacles: dict[str, tuple[str | None, ...]]
    faults: dict[str, str] = field(default_factory=dict)


def measure(records: RecordBatch, indicators: Indicators, seconds: Seconds | None = None) -> Measures:
    """Measure all outputs of indicators for a batch; values that cannot be measured are NaN, with the reason.

    An indicator receives only the samples of its own channels, read-only: no name, group, label or remark of
    a record, and nothing that depends on the other indicators. If it raises, or its outputs differ from its
    declaration, the fault is stored as the obstacle of every record; the other indicators are still measured.

    Parameters
    ----------
    records : RecordBatch
    indicators : mapping of str to Indicator
        Label → indicator.
    seconds : dict, optional
        Label → CPU time [s]; the time of this batch is added.
    """
    measures = Measures({}, {})
    blinded = _read_only(records.blinded())
    for label, indicator in indicators.items():
        start = process_time()
        try:
            known = indicator.channels | indicator.optional_channels
            held = {channel: each for channel, each in blinded.channels.items() if channel in known}
            seen = replace(blinded, channels=held)
            reasons = _obstacles(seen, records.remarks, indicator)
            numbers = _numbers(seen, indicator, reasons)
        except FaultyIndicatorError as fault:
            measures.faults[label] = str(fault)
            reasons = [str(fault)] * records.n_record
            numbers = _nothing(blinded, indicator)
        if seconds is not None:
            seconds[label] = seconds.get(label, 0.0) + process_time() - start
        flat = [each.reshape(records.n_record, prod(each.shape[1:])) for each in numbers.values()]
        every = np.hstack([np.empty((records.n_record, 0)), *flat])
        infinite, finite = np.any(np.isinf(every), axis=1), np.any(np.isfinite(every), axis=1)
        for name, array in numbers.items():
            measures.values[f"{label}.{name}"] = np.where(np.isfinite(array), array, np.nan)
        measures.obstacles[label] = tuple(
            (f"indicator {indicator.name!r} gives infinite numbers" if infinite[row] else indicator.absence)
            if reason is None and not finite[row]
            else reason
            for row, reason in enumerate(reasons)
        )
    return measures


def output_unit(indicator: Indicator[Any], output: Output, records: RecordBatch) -> str:
    """Unit of an output; counts, or counts per unit, if its channel has no scale."""
    units = {channel.unit: records.unit(channel) for channel in sorted(indicator.channels & records.relative)}
    unit, _, per = output.unit.rpartition("/")
    if output.unit in units:
        return units[output.unit]
    return f"{units[unit]}/{per}" if unit in units else output.unit


def _read_only(records: RecordBatch) -> RecordBatch:
    """Read-only samples, so that no indicator can change the input of another.

    Each record is contiguous in memory, so that rounding of sums does not depend on the batch.
    """
    handed = {channel: np.ascontiguousarray(samples).view() for channel, samples in records.channels.items()}
    for samples in handed.values():
        samples.flags.writeable = False
    return replace(records, channels=handed)


def _numbers(
    records: RecordBatch, indicator: Indicator[Any], reasons: Sequence[str | None]
) -> dict[str, Array]:
    """Outputs of an indicator; NaN if there is an obstacle, infinite if they overflow."""
    numbers = _nothing(records, indicator)
    fit = [row for row, reason in enumerate(reasons) if reason is None]
    if not fit:
        return numbers
    chosen = records if len(fit) == records.n_record else _read_only(records.rows(fit))
    try:
        with np.errstate(all="ignore"):
            measured = indicator.measure(chosen)
    except Exception as error:
        raise raised(indicator, error) from error
    if fault := fault_of_outputs(measured, indicator, len(fit)):
        raise FaultyIndicatorError(f"indicator {indicator.name!r} gives {fault}")
    for name, array in numbers.items():
        array[fit] = measured[name]
    return numbers


def _nothing(records: RecordBatch, indicator: Indicator[Any]) -> dict[str, Array]:
    return {
        output.name: np.full((records.n_record, *output.dims.values()), np.nan)
        for output in indicator.outputs
    }


def _obstacles(
    records: RecordBatch, remarks: Sequence[Sequence[Issue]], indicator: Indicator[Any]
) -> list[str | None]:
    try:
        common = _common_obstacle(records, indicator)
    except Exception as error:
        raise raised(indicator, error) from error
    own = [_own_obstacle(each, indicator) for each in remarks]
    if common or not isinstance(indicator.options, NominalActuator):
        return [common or each for each in own]
    return [
        each or unfit for each, unfit in zip(own, indicator.options.unfit_positions(records), strict=True)
    ]


def _common_obstacle(records: RecordBatch, indicator: Indicator[Any]) -> str | None:
    missing = sorted(indicator.channels - records.channels.keys())
    if missing:
        return f"has no {' and no '.join(missing)}{spool_remedy(missing, indicator)}"
    relative = sorted(indicator.channels & records.relative)
    if indicator.needs_scale and relative:
        found = "is normalised" if relative[0] in records.normalized else "is in counts"
        return f"{relative[0]} {found}, but {indicator.name} needs it in {relative[0].unit}"
    return indicator.obstacle(records)


def spool_remedy(missing: Collection[Channel], indicator: Indicator[Any]) -> str:
    """The option that replaces a measured spool position; empty if something else is missing."""
    is_asked = getattr(indicator.options, "spool", "") == "measured"
    if not is_asked or Channel.SPOOL_POSITION not in missing:
        return ""
    return f"; 'spool: command' under {indicator.name} computes it from the {Channel.INPUT_VOLTAGE}"


def _own_obstacle(remarks: Sequence[Issue], indicator: Indicator[Any]) -> str | None:
    concerned = {"", *indicator.channels}
    return next((each.message for each in remarks if each.is_unusable and each.where in concerned), None)


@dataclass(frozen=True)
class MeasuredOutput:
    """An output of an indicator.

    Attributes
    ----------
    label : str
        Label of the indicator.
    unit : str
        Unit of the values: SI, counts, or 1.
    channels : tuple of Channel
        Channels that the indicator needs, sorted.
    """

    label: str
    output: Output
    unit: str
    channels: tuple[Channel, ...]

    @property
    def name(self) -> str:
        """``label.output``."""
        return f"{self.label}.{self.output.name}"

    @property
    def size(self) -> int:
        """Number of values per record."""
        return prod(self.output.dims.values())


@dataclass(frozen=True)
class RecordMeasures:
    """Measured values of one record.

    Attributes
    ----------
    record_id, source, group, label : str
        As in a batch; empty if unknown.
    status : str
        ``ok``, or the kinds of the remarks on the record or on used channels, and ``doubtful`` if there are
        doubts, separated by commas; without any of these and any number ``not_measured``.
    values : dict of str to ndarray, shape (*dims)
        Name of a column → its values; NaN if there are none.
    reasons : dict of str to str
        Label of an indicator → why it could not be measured.
    is_rejected : bool
        Whether the record was rejected, so that nothing could be measured.
    faults : mapping of str to str
        Label of an indicator that failed → its error; this is also its reason.
    sketch : Sketch or None
        What tells copies, if asked for.
    doubts : tuple of Issue
        Estimates that are physically impossible, and models that do not explain the record.
    """

    record_id: str
    source: str
    group: str
    label: str
    status: str
    values: dict[str, Array]
    reasons: dict[str, str]
    is_rejected: bool = False
    faults: Mapping[str, str] = field(default_factory=dict)
    sketch: Sketch | None = None
    doubts: tuple[Issue, ...] = ()

    @property
    def has_numbers(self) -> bool:
        """Whether any indicator has a value."""
        return any(np.isfinite(values).any() for values in self.values.values())


def used_channels(indicators: Indicators) -> frozenset[Channel]:
    """All channels that the indicators need, or use if available."""
    return frozenset().union(
        *(indicator.channels | indicator.optional_channels for indicator in indicators.values())
    )


def measure_sources(
    sources: Sequence[RecordSource],
    indicators: Indicators,
    *,
    is_near: Callable[[RecordSource], bool] | None = None,
) -> tuple[tuple[MeasuredOutput, ...], Iterator[RecordMeasures]]:
    """Columns, and an iterator over the records of all sources; one batch is in memory at a time.

    With `is_near`, records have what tells copies, also near ones of the sources for which it is true.
    """
    batches = ((source, batch) for source in sources for batch in source.batches(labels=True))
    leading = []
    for source, batch in batches:
        leading.append((source, batch))
        if batch.n_record:
            break
    columns = _columns(indicators, leading[-1][1] if leading else RecordBatch({}, 1.0, ()))
    return columns, _measured(chain(leading, batches), indicators, columns, is_near)


def _columns(indicators: Indicators, records: RecordBatch) -> tuple[MeasuredOutput, ...]:
    return tuple(
        MeasuredOutput(
            label, output, output_unit(indicator, output, records), tuple(sorted(indicator.channels))
        )
        for label, indicator in indicators.items()
        for output in indicator.outputs
    )


def _measured(
    batches: Iterator[tuple[RecordSource, RecordBatch]],
    indicators: Indicators,
    columns: Sequence[MeasuredOutput],
    is_near: Callable[[RecordSource], bool] | None,
) -> Iterator[RecordMeasures]:
    used = used_channels(indicators)
    for source, batch in batches:
        _require_same_units(source, batch, indicators, columns)
        measures = measure(batch, indicators)
        doubts = [
            doubts_of(indicator, measures.values, f"{label}.") for label, indicator in indicators.items()
        ]
        for row in range(batch.n_record):
            own = tuple(chain.from_iterable(of_indicator[row] for of_indicator in doubts if of_indicator))
            record = _record(batch, measures, row, used, own)
            if is_near is not None:
                record = replace(record, sketch=sketch_of(batch, row, is_near=is_near(source)))
            yield record
        yield from _rejected(batch, columns)


def _require_same_units(
    source: RecordSource, batch: RecordBatch, indicators: Indicators, columns: Sequence[MeasuredOutput]
) -> None:
    for first, now in zip(columns, _columns(indicators, batch), strict=True):
        if batch.n_record and first.unit != now.unit:
            raise DataError(
                f"{source.name}: {now.name} is in {now.unit}, but in {first.unit} in an earlier source;"
                " measure these sources separately"
            )


def _record(
    batch: RecordBatch, measures: Measures, row: int, used: frozenset[Channel], doubts: tuple[Issue, ...]
) -> RecordMeasures:
    concerning = (each for each in batch.remarks[row] if not each.where or each.where in used)
    kinds = [*dict.fromkeys(remark.kind for remark in concerning), *(["doubtful"] if doubts else [])]
    values = {name: found[row] for name, found in measures.values.items()}
    has_numbers = any(np.isfinite(found).any() for found in values.values())
    return RecordMeasures(
        batch.record_ids[row],
        batch.sources[row],
        batch.groups[row],
        batch.labels[row] if batch.labels else "",
        ",".join(kinds) or ("ok" if has_numbers else "not_measured"),
        values,
        {label: reason for label, rows in measures.obstacles.items() if (reason := rows[row]) is not None},
        faults=measures.faults,
        doubts=doubts,
    )


def _rejected(batch: RecordBatch, columns: Sequence[MeasuredOutput]) -> Iterator[RecordMeasures]:
    for record in batch.rejected:
        reasons = dict.fromkeys((column.label for column in columns), record.remark.message)
        identity = record.record_id, record.source, record.group, record.label
        yield RecordMeasures(*identity, record.remark.kind, {}, reasons, is_rejected=True)


@dataclass
class Counted:
    """What became of measured records: numbers of them, the first reasons, faulty indicators and doubts."""

    n_record: int = 0
    n_rejected: int = 0
    n_empty: int = 0
    n_unmeasured: int = 0
    first_rejection: str = ""
    first_reason: str = ""
    faults: dict[str, None] = field(default_factory=dict)
    doubts: list[Issue] = field(default_factory=list)

    def count(self, records: Iterable[RecordMeasures]) -> Iterator[RecordMeasures]:
        """The records as they come."""
        for record in records:
            self.n_record += 1
            self.n_rejected += record.is_rejected
            self.n_empty += not (record.is_rejected or record.has_numbers)
            self.faults |= dict.fromkeys(record.faults.values())
            self.doubts += record.doubts
            others = ((label, text) for label, text in record.reasons.items() if label not in record.faults)
            label, reason = next(others, ("", record.status))
            if record.is_rejected:
                self.first_rejection = self.first_rejection or f"{record.record_id}: {reason}"
            elif label:
                self.n_unmeasured += 1
                self.first_reason = self.first_reason or f"{label}: {reason}"
            yield record

    @property
    def is_lacking(self) -> bool:
        """Whether records could not be measured, or an indicator failed."""
        return bool(self.n_rejected or self.n_empty or self.faults)

    def sentences(self) -> Iterator[str]:
        """Faulty indicators, and records without numbers."""
        yield from (f"failed: {fault}" for fault in self.faults)
        of = f"of {counted(self.n_record, 'record')}"
        if self.n_rejected:
            yield f"rejected: {self.n_rejected:,} {of}; {self.first_rejection}"
        if self.n_empty:
            yield f"without any number: {self.n_empty:,} {of}"

    def unmeasured(self) -> Iterator[str]:
        """Records that some indicator could not measure, with the first reason."""
        if self.n_unmeasured:
            of = counted(self.n_unmeasured, "record")
            yield f"without some numbers: {of}; the first: {self.first_reason}"
