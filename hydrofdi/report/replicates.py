"""Comparison of rows with independent healthy replicates: is a δ larger than between healthy actuators?

A sealed run is its own matched baseline, so that its δ is zero by construction. Against the mean of
replicates, each with its own noise and its own draw of what varies without a fault, it need not be; and the δ
of each replicate against the mean of the others says how large a δ may be without a leak.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.intervals import Share, clustered_share
from hydrofdi.report.runs.rows import TableRow, largest_positive
from hydrofdi.report.runs.table import SensitivityTable
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.change import percentage_change

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HealthyRange:
    """The replicates of one healthy run.

    Attributes
    ----------
    position : int
        Row of the healthy run.
    bulk_modulus : float
        β [Pa].
    deltas : ndarray, shape (n_replicate, n_level)
        δ of each replicate against the mean of the others [%].
    mean : ndarray, shape (n_level,)
        Mean RMS of the replicates [Pa].
    """

    position: int
    bulk_modulus: float
    deltas: Array
    mean: Array

    @property
    def n_replicate(self) -> int:
        """Number of replicates that succeeded."""
        return len(self.deltas)

    @property
    def low(self) -> Array:
        """The smallest δ of each level [%]."""
        low: Array = self.deltas.min(axis=0)
        return low

    @property
    def high(self) -> Array:
        """The largest δ of each level [%]."""
        high: Array = self.deltas.max(axis=0)
        return high


@dataclass(frozen=True)
class ReplicatedRow:
    """A row of the table against the replicates of its healthy run.

    Attributes
    ----------
    row : TableRow
    healthy : HealthyRange
    delta : tuple of float
        δ of each level against the mean of the replicates [%].
    outside : tuple of bool
        Whether it lies outside of the range of the replicates' own δ.
    """

    row: TableRow
    healthy: HealthyRange
    delta: tuple[float, ...]
    outside: tuple[bool, ...]


@dataclass(frozen=True)
class ReplicateStudy:
    """All rows against healthy replicates.

    Attributes
    ----------
    is_settled : bool
        Whether RMS are those of the settled records.
    ranges : tuple of HealthyRange
        One for each healthy run, by β.
    fixed, matched : tuple of ReplicatedRow
        Against the replicates of the fixed and of the matched baseline.
    """

    is_settled: bool
    ranges: tuple[HealthyRange, ...]
    fixed: tuple[ReplicatedRow, ...]
    matched: tuple[ReplicatedRow, ...]

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return int(self.ranges[0].mean.size)

    def alarms(self, level: int) -> Share:
        """Replicates in which a level has the largest positive δ against the mean of the others.

        Replicates of one healthy run share their mean, so they depend on each other slightly.
        """
        deltas = np.concatenate([healthy.deltas for healthy in self.ranges])
        alarms = np.array([largest_positive(levels) == level for levels in deltas.tolist()])
        return clustered_share(alarms, np.arange(len(alarms)))


def study_replicates(table: SensitivityTable, data: ExperimentData) -> ReplicateStudy | None:
    """Rows against healthy replicates; None if the experiment has none that succeeded.

    Parameters
    ----------
    table : SensitivityTable
        Made from `data`.
    data : ExperimentData
    """
    if not data.has_replicates:
        return None
    rms = data.columns[names.SETTLED_DETAIL_RMS if table.has_settled else names.DETAIL_RMS]
    ranges = {
        position: healthy
        for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist()
        if (healthy := _healthy_range(data, rms, position)) is not None
    }
    if not ranges:
        return None
    return ReplicateStudy(
        is_settled=table.has_settled,
        ranges=tuple(sorted(ranges.values(), key=lambda healthy: (healthy.bulk_modulus, healthy.position))),
        fixed=_replicated_rows(table, rms, ranges, data.fixed_baseline),
        matched=_replicated_rows(table, rms, ranges, data.matched_baseline),
    )


def _healthy_range(data: ExperimentData, rms: Array, position: int) -> HealthyRange | None:
    found = rms[data.replicate_of == position]
    found = found[np.isfinite(found).all(axis=1)]
    if len(found) < 2:
        return None
    mean_of_others = (found.sum(axis=0) - found) / (len(found) - 1)
    return HealthyRange(
        position=position,
        bulk_modulus=float(data.columns[names.BULK_MODULUS][position]),
        deltas=percentage_change(mean_of_others, found),
        mean=found.mean(axis=0),
    )


def _replicated_rows(
    table: SensitivityTable, rms: Array, ranges: dict[int, HealthyRange], baseline: NDArray[np.int64]
) -> tuple[ReplicatedRow, ...]:
    rows = []
    for row in table.rows:
        healthy = ranges.get(int(baseline[row.position]))
        if healthy is not None:
            delta = percentage_change(healthy.mean, rms[row.position])
            outside = (delta < healthy.low) | (delta > healthy.high)
            rows.append(ReplicatedRow(row, healthy, tuple(delta.tolist()), tuple(outside.tolist())))
    return tuple(rows)
