"""Rows against independent healthy replicates: is a δ larger than between healthy actuators?

A sealed run is its own matched baseline, so that its δ is zero by construction. Against the mean of
replicates, each with its own noise and its own draw of what varies without a fault, it need not be; and the δ
of each replicate against the mean of the others says how large a δ may be without a leak.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.document import Block, group_breaks
from hydrofdi.report.intervals import Share, clustered_share
from hydrofdi.report.runs import RunTable, TableRow, finite, largest_positive, level_name
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import lead_columns, modulus_column, share_text, signed, span_text
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.change import percentage_change
from hydrofdi.units import convert

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HealthyRange:
    """The replicates of one healthy run.

    `deltas`, shape (n_replicate, n_level), are δ of each against the mean of the others [%]; `mean`, shape
    (n_level,), is the mean RMS of all [Pa].
    """

    bulk_modulus: float
    deltas: Array
    mean: Array

    @property
    def ends(self) -> Array:
        """The smallest and the largest δ of each level [%], shape (2, n_level)."""
        return np.stack([self.deltas.min(axis=0), self.deltas.max(axis=0)])


@dataclass(frozen=True)
class ReplicatedRow:
    """δ of a row against the mean of the replicates of its healthy run [%], and whether it is outside."""

    row: TableRow
    delta: tuple[float, ...]
    outside: tuple[bool, ...]


@dataclass(frozen=True)
class ReplicateStudy:
    """All rows against the replicates of their fixed and of their matched baselines; ranges by β."""

    is_settled: bool
    ranges: tuple[HealthyRange, ...]
    rows: dict[str, tuple[ReplicatedRow, ...]]

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


def study_replicates(table: RunTable, data: ExperimentData) -> ReplicateStudy | None:
    """Rows against healthy replicates; None if the experiment has none that succeeded."""
    if not data.has_replicates:
        return None
    rms = data.columns[names.SETTLED_DETAIL_RMS if table.has_settled else names.DETAIL_RMS]
    ranges: dict[int, HealthyRange] = {}
    for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist():
        found = rms[data.replicate_of == position]
        found = found[np.isfinite(found).all(axis=1)]
        if len(found) > 1:
            others = (found.sum(axis=0) - found) / (len(found) - 1)
            modulus = float(data.columns[names.BULK_MODULUS][position])
            ranges[position] = HealthyRange(modulus, percentage_change(others, found), found.mean(axis=0))
    if not ranges:
        return None
    baselines = {"fixed": data.fixed_baseline, "matched": data.matched_baseline}
    return ReplicateStudy(
        table.has_settled,
        tuple(sorted(ranges.values(), key=lambda healthy: healthy.bulk_modulus)),
        {name: tuple(_replicated(table, rms, ranges, rows)) for name, rows in baselines.items()},
    )


def _replicated(
    table: RunTable, rms: Array, ranges: dict[int, HealthyRange], baseline: NDArray[np.int64]
) -> Iterator[ReplicatedRow]:
    for row in table.rows:
        healthy = ranges.get(int(baseline[row.position]))
        if healthy is not None:
            delta = percentage_change(healthy.mean, rms[row.position])
            outside = (delta < healthy.ends[0]) | (delta > healthy.ends[1])
            yield ReplicatedRow(row, tuple(delta.tolist()), tuple(outside.tolist()))


def replicates_record(study: ReplicateStudy) -> dict[str, Any]:
    """Ranges of the replicates, the rows against them, and how often a rule alarms on a healthy actuator."""
    shares = {level_name(level): study.alarms(level) for level in range(study.n_level)}
    return {
        "settled": study.is_settled,
        "ranges": [
            {
                "bulk_modulus_MPa": convert(healthy.bulk_modulus, "MPa"),
                "replicates": len(healthy.deltas),
                "low_percent": healthy.ends[0].tolist(),
                "high_percent": healthy.ends[1].tolist(),
            }
            for healthy in study.ranges
        ],
        "rows": [
            {
                "run_id": entry.row.run_id,
                "baseline": baseline,
                "delta_percent": [finite(value) for value in entry.delta],
                "outside_healthy_range": list(entry.outside),
            }
            for baseline, entries in study.rows.items()
            for entry in entries
        ],
        "alarms_on_healthy": {
            name: {"alarms": share.count, "of": share.total, "interval_95": [share.low, share.high]}
            for name, share in shares.items()
        },
    }


def replicates_block(
    table: RunTable, data: ExperimentData, study: ReplicateStudy, levels: Sequence[int] | None = None
) -> Block:
    """Does a leak move the details more than healthy actuators differ; by default at all levels."""
    return Block(
        "replicates",
        "Healthy replicates: what differs without a leak",
        tuple(_sentences(data, study, levels or range(table.n_level))),
        (_ranges_table(study), *(_rows_table(table, study, name) for name in ("matched", "fixed"))),
    )


def _sentences(data: ExperimentData, study: ReplicateStudy, levels: Sequence[int]) -> Iterator[str]:
    config = data.experiment.replicates
    found = [len(healthy.deltas) for healthy in study.ranges]
    n, records = max(found), "settled records" if study.is_settled else "records as configured"
    over = ", ".join(config.over) or "noise alone"
    yield (
        f"Each healthy run has {counted(n, 'independent replicate')} ({over}; {records}). δ is taken against"
        " their mean; their own range is that of each against the mean of the others. Another healthy one"
        f" would lie outside the range of a level in about 2 of {n + 1} cases."
    )
    lost = config.count * len(found) - sum(found)
    if lost:
        yield f"Left out because they failed or have not settled: {counted(lost, 'replicate')}."
    for level in levels:
        leaky = [entry for entry in study.rows["matched"] if not entry.row.is_sealed]
        sealed = [entry for entry in study.rows["fixed"] if entry.row.is_sealed]
        share = share_text(study.alarms(level), with_interval=True)
        yield (
            f"δd{level + 1} lies outside of the healthy range in {sum(e.outside[level] for e in leaky)} of"
            f" {counted(len(leaky), 'leaky run')} against the matched baseline, and in"
            f" {sum(e.outside[level] for e in sealed)} of {counted(len(sealed), 'sealed run')} against the"
            f" fixed baseline; “δd{level + 1} is the largest positive” holds for {share} of the replicates."
        )


def _ranges_table(study: ReplicateStudy) -> Table:
    ranges = study.ranges
    levels = (
        Column(
            f"δd{level + 1}",
            [span_text(*map(signed, healthy.ends[:, level].tolist())) for healthy in ranges],
        )
        for level in range(study.n_level)
    )
    lead = modulus_column([healthy.bulk_modulus for healthy in ranges])
    return Table(
        (lead, Column("Replicates", [len(healthy.deltas) for healthy in ranges]), *levels),
        "δ [%] of the healthy replicates, each against the mean of the others",
        "replicates-ranges",
    )


def _rows_table(table: RunTable, study: ReplicateStudy, baseline: str) -> Table:
    entries = study.rows[baseline]
    rows = [entry.row for entry in entries]
    levels = (
        Column(
            f"δd{k + 1}",
            [entry.delta[k] for entry in entries],
            text=signed,
            strong=[place for place, entry in enumerate(entries) if entry.outside[k]],
        )
        for k in range(study.n_level)
    )
    lead = lead_columns(table, rows)
    return Table(
        (*lead, *levels),
        f"δ [%] against the mean of the replicates of the {baseline} baseline",
        f"replicates-{baseline}",
        ("Marked: outside the range of the healthy replicates.",),
        group_breaks([row.leakage_request for row in rows]),
        n_lead=len(lead),
    )
