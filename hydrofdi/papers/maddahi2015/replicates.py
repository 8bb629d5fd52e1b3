"""Rows against independent healthy replicates: is a δ larger than between healthy actuators?

A sealed run is its own matched baseline, so that its δ is zero by construction. Against the mean of
replicates, each with its own noise and its own draw of what varies without a fault, it need not be; and the δ
of each replicate against the mean of the others says how large a δ may be without a leak.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from hydrofdi.papers.maddahi2015.standings import Mask
from hydrofdi.report.composition import View
from hydrofdi.report.document import Block
from hydrofdi.report.forms.numbers import plain
from hydrofdi.report.intervals import clustered_share
from hydrofdi.report.runs import Array, RunTable, best_levels
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import modulus_column, share_text, signed, span_text
from hydrofdi.settings.counting import counted
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.change import percentage_change
from hydrofdi.units import convert


class HealthyRange(NamedTuple):
    """The replicates of a healthy run: β [Pa], δ of each against the mean of the others [%], mean RMS [Pa].

    `deltas` has shape (n_replicate, n_level), `ends` are the smallest and the largest, shape (2, n_level).
    """

    bulk_modulus: float
    deltas: Array
    ends: Array
    mean: Array


class ReplicatedRows(NamedTuple):
    """δ of rows against the mean of replicates [%], and whether it lies outside, both (n_row, n_level)."""

    rows: RunTable
    deltas: Array
    outside: Mask


class ReplicateStudy(NamedTuple):
    """All rows against the replicates of their fixed and of their matched baselines; ranges by β."""

    is_settled: bool
    ranges: list[HealthyRange]
    rows: dict[str, ReplicatedRows]

    @property
    def alarms(self) -> Mask:
        """Whether a level has the largest positive δ of a replicate, shape (n_replicate, n_level)."""
        deltas = np.concatenate([healthy.deltas for healthy in self.ranges])
        found: Mask = best_levels(deltas)[:, None] == np.arange(deltas.shape[1])
        return found


def study_replicates(table: RunTable, data: ExperimentData) -> ReplicateStudy | None:
    """Rows against healthy replicates; None if the experiment has none that succeeded."""
    rms = data.columns[names.SETTLED_DETAIL_RMS if table.has_settled else names.DETAIL_RMS]
    ranges: dict[int, HealthyRange] = {}
    for position in np.unique(data.replicate_of[data.replicate_of >= 0]).tolist():
        found = rms[data.replicate_of == position]
        found = found[np.isfinite(found).all(axis=1)]
        if len(found) > 1:
            deltas = percentage_change((found.sum(axis=0) - found) / (len(found) - 1), found)
            ends = np.stack([deltas.min(axis=0), deltas.max(axis=0)])
            modulus = float(data.columns[names.BULK_MODULUS][position])
            ranges[position] = HealthyRange(modulus, deltas, ends, found.mean(axis=0))
    if not ranges:
        return None
    rows = {}
    for name, baseline in (("fixed", data.fixed_baseline), ("matched", data.matched_baseline)):
        own = table.of(np.isin(baseline[table.positions], list(ranges)))
        healthy = [ranges[position] for position in baseline[own.positions].tolist()]
        means = np.array([each.mean for each in healthy]).reshape(-1, rms.shape[1])
        ends = np.array([each.ends for each in healthy]).reshape(-1, 2, rms.shape[1])
        delta = percentage_change(means, rms[own.positions])
        rows[name] = ReplicatedRows(own, delta, (delta < ends[:, 0]) | (delta > ends[:, 1]))
    return ReplicateStudy(
        table.has_settled, sorted(ranges.values(), key=lambda each: each.bulk_modulus), rows
    )


def replicates_views(table: RunTable, data: ExperimentData) -> Iterator[View]:
    """Does a leak move the details more than healthy actuators differ."""
    if (study := study_replicates(table, data)) is None:
        return
    title = "Healthy replicates: what differs without a leak"
    tables = (_levels_table(study), _ranges_table(study))
    block = Block("replicates", title, tuple(_sentences(data, study)), tables)
    yield block, {"replicates": _record(study)}


def _record(study: ReplicateStudy) -> dict[str, Any]:
    # replicates of one healthy run share their mean, so they depend on each other slightly
    shares = [clustered_share(each, np.arange(len(each))) for each in study.alarms.T]
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
                "run_id": run_id,
                "baseline": baseline,
                "delta_percent": plain(delta),
                "outside_healthy_range": outside,
            }
            for baseline, own in study.rows.items()
            for run_id, delta, outside in zip(
                own.rows.texts(names.RUN_ID), own.deltas, own.outside.tolist(), strict=True
            )
        ],
        "alarms_on_healthy": {
            f"d{level}": {"alarms": share.count, "of": share.total, "interval_95": [share.low, share.high]}
            for level, share in enumerate(shares, 1)
        },
    }


def _sentences(data: ExperimentData, study: ReplicateStudy) -> Iterator[str]:
    config, found = data.experiment.replicates, [len(healthy.deltas) for healthy in study.ranges]
    n, records = max(found), "settled records" if study.is_settled else "records as configured"
    over = ", ".join(config.over) or "noise alone"
    yield (
        f"Each healthy run has {counted(n, 'independent replicate')} ({over}; {records}). δ is taken against"
        " their mean; their own range is that of each against the mean of the others. Another healthy one"
        f" would lie outside the range of a level in about 2 of {n + 1} cases."
    )
    if lost := config.count * len(found) - sum(found):
        yield f"Left out because they failed or have not settled: {counted(lost, 'replicate')}."


def _levels_table(study: ReplicateStudy) -> Table:
    """In how many runs each level lies outside of the healthy range, and how often it leads by chance."""
    columns = [Column("Level", [f"d{k + 1}" for k in range(study.alarms.shape[1])], is_text=True)]
    for title, name, is_sealed in (("Leaky", "matched", False), ("Sealed", "fixed", True)):
        own = study.rows[name]
        kept = own.rows.is_sealed == is_sealed
        texts = [f"{n} of {kept.sum()}" for n in own.outside[kept].sum(axis=0).tolist()]
        columns.append(Column(f"{title} outside", texts))
    shares = [clustered_share(each, np.arange(len(each))) for each in study.alarms.T]
    texts = [share_text(share, with_interval=True) for share in shares]
    columns.append(Column("Largest positive of a replicate", texts))
    note = (
        "Outside: runs outside of the range of their healthy replicates; leaky ones against the matched"
        " baseline, sealed ones against the fixed one."
    )
    return Table(tuple(columns), "Levels against the healthy replicates", "replicates-levels", (note,))


def _ranges_table(study: ReplicateStudy) -> Table:
    ends = np.stack([healthy.ends for healthy in study.ranges])
    columns = (
        modulus_column([healthy.bulk_modulus for healthy in study.ranges]),
        Column("Replicates", [len(healthy.deltas) for healthy in study.ranges]),
        *(
            Column(f"δd{k + 1}", [span_text(*map(signed, each)) for each in ends[:, :, k].tolist()])
            for k in range(ends.shape[2])
        ),
    )
    title = "δ [%] of the healthy replicates, each against the mean of the others"
    return Table(columns, title, "replicates-ranges")
