"""Measurement of indicators for a batch of records."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from time import process_time
from typing import Any

import numpy as np

from hydrofdi.errors import Issue
from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.indicators.faults import FaultyIndicatorError, gives_infinite, raised, require_sound_outputs
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.records import Array, Channel, RecordBatch

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
            seen = seen_by(indicator, blinded)
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
        infinite, found = np.any(np.isinf(every), axis=1), np.any(np.isfinite(every), axis=1)
        for name, array in numbers.items():
            measures.values[f"{label}.{name}"] = np.where(np.isfinite(array), array, np.nan)
        measures.obstacles[label] = tuple(
            (gives_infinite(indicator) if infinite[row] else indicator.absence)
            if reason is None and not found[row]
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


def seen_by(indicator: Indicator[Any], records: RecordBatch) -> RecordBatch:
    """Records reduced to the channels of an indicator."""
    seen = indicator.channels | indicator.optional_channels
    return replace(records, channels={each: records[each] for each in records.channels if each in seen})


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
    require_sound_outputs(measured, indicator, len(fit))
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
        return f"{relative[0]} is in counts, but {indicator.name} needs it in {relative[0].unit}"
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
