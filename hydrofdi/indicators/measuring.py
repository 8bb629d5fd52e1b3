"""Indicators of a batch of records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array, RecordBatch, Remark

Indicators = Mapping[str, Indicator[Any]]
"""Label → indicator."""


@dataclass(frozen=True)
class Measures:
    """What indicators gave for a batch.

    Attributes
    ----------
    values : dict of str to ndarray, shape (n_record, *dims)
        ``label.output`` → numbers; NaN where there are none.
    obstacles : dict of str to tuple of (str or None), length n_record
        Label → why a record has no numbers; None where it has any.
    """

    values: dict[str, Array]
    obstacles: dict[str, tuple[str | None, ...]]


def measure(records: RecordBatch, indicators: Indicators) -> Measures:
    """All outputs of indicators for a batch; what cannot be measured is NaN, with the reason.

    Indicators are handed the samples alone: no name, group, label or remark of a record.

    Parameters
    ----------
    records : RecordBatch
    indicators : mapping of str to Indicator
        Label → indicator.
    """
    values: dict[str, Array] = {}
    obstacles: dict[str, tuple[str | None, ...]] = {}
    blinded = _in_rows(records.blinded())
    for label, indicator in indicators.items():
        common = _common_obstacle(blinded, indicator)
        reasons = [common or _own_obstacle(remarks, indicator) for remarks in records.remarks]
        fit = [row for row, reason in enumerate(reasons) if reason is None]
        numbers = _finite(_numbers(blinded, indicator, fit))
        values |= {f"{label}.{name}": array for name, array in numbers.items()}
        absent = indicator.absence
        obstacles[label] = tuple(
            absent if reason is None and not found else reason
            for reason, found in zip(reasons, _found(numbers, records.n_record), strict=True)
        )
    return Measures(values, obstacles)


def output_unit(indicator: Indicator[Any], output: Output, records: RecordBatch) -> str:
    """Unit of an output; that of the record, also per something, where a channel has no scale."""
    units = {channel.unit: records.unit(channel) for channel in sorted(indicator.channels & records.relative)}
    unit, _, per = output.unit.rpartition("/")
    if output.unit in units:
        return units[output.unit]
    return f"{units[unit]}/{per}" if unit in units else output.unit


def _in_rows(records: RecordBatch) -> RecordBatch:
    """Each record in one piece of memory, so that sums over it are rounded alike in any batch."""
    rows = {channel: np.ascontiguousarray(samples) for channel, samples in records.channels.items()}
    return replace(records, channels=rows)


def _numbers(records: RecordBatch, indicator: Indicator[Any], fit: list[int]) -> dict[str, Array]:
    if len(fit) == records.n_record > 0:
        with np.errstate(all="ignore"):
            return dict(indicator.measure(records))
    numbers = {
        output.name: np.full((records.n_record, *output.dims.values()), np.nan)
        for output in indicator.outputs
    }
    if fit:
        with np.errstate(all="ignore"):
            measured = indicator.measure(records.rows(fit))
        for name, array in numbers.items():
            array[fit] = measured[name]
    return numbers


def _finite(numbers: Mapping[str, Array]) -> dict[str, Array]:
    """NaN for what overflows."""
    return {name: np.where(np.isfinite(array), array, np.nan) for name, array in numbers.items()}


def _found(numbers: dict[str, Array], n_record: int) -> NDArray[np.bool_]:
    """Whether a record has any number, shape (n_record,)."""
    found = np.zeros(n_record, dtype=bool)
    for array in numbers.values():
        found |= ~np.isnan(array).all(axis=tuple(range(1, array.ndim)))
    return found


def _common_obstacle(records: RecordBatch, indicator: Indicator[Any]) -> str | None:
    missing = sorted(indicator.channels - records.channels.keys())
    if missing:
        return f"has no {' and no '.join(missing)}"
    relative = sorted(indicator.channels & records.relative)
    if indicator.needs_scale and relative:
        found = "is divided by another" if relative[0] in records.normalized else "is in counts"
        return f"{relative[0]} {found}, and {indicator.name} needs it in {relative[0].unit}"
    return indicator.obstacle(records)


def _own_obstacle(remarks: Sequence[Remark], indicator: Indicator[Any]) -> str | None:
    return next(
        (
            remark.text
            for remark in remarks
            if remark.is_unusable and (remark.channel is None or remark.channel in indicator.channels)
        ),
        None,
    )
