"""Measured values of each record of several sources, for tables and files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import prod

import numpy as np

from hydrofdi.errors import DataError, Issue
from hydrofdi.indicators.contract import Output
from hydrofdi.indicators.faults import doubts_of
from hydrofdi.indicators.measuring import Indicators, Measures, measure, output_unit
from hydrofdi.records import Array, Channel, RecordBatch, RecordSource
from hydrofdi.records.copies import Sketch, sketch_of


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
        place = record.record_id, record.source, record.group, record.label
        yield RecordMeasures(*place, record.remark.kind, {}, reasons, is_rejected=True)
