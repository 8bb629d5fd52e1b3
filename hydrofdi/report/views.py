"""What an experiment asks for beyond its indicators: external leakage, and healthy replicates.

External leakage: does an approximation separate it from internal leakage and from a change of EBM? After
Goharrizi and Sepehri, International Journal of Fluid Power, who use the level-4 approximation. Its RMS is the
choice made here.

Replicates: is a δ larger than between healthy actuators? A sealed run is its own matched baseline: its
δ is zero by construction. Against the mean of replicates, each with its own noise and its own draw of what
varies without a fault, it need not be; and the δ of each replicate against the mean of the others says how
large a δ may be without a leak.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.evaluation.rates import Rate
from hydrofdi.report.intervals import clustered_share, span_of
from hydrofdi.report.runs import EXTERNAL, Array, RunTable, best_levels
from hydrofdi.report.table import Block, Column, Table, finite, row_records
from hydrofdi.report.wording import modulus_column, share_text, signed, span_text
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.wavelet import percentage_change
from hydrofdi.units import convert

View = tuple[Block, dict[str, Any]]

_D2, _LEVEL = 1, 3
"""Positions of d2, and of a4; the deepest level if there are fewer."""


def asked_views(table: RunTable) -> Iterator[View]:
    """Sections and data of the varied external leakage, and of replicates."""
    if table.varies_external:
        yield external_view(table)
    if table.data.has_replicates:
        yield from replicates_views(table, table.data)


def external_view(table: RunTable) -> View:
    """Ranges of δ with the same leaky chambers, and how far they are from those without external leakage.

    δ is against the fixed, δ′ against the matched baseline: of the settled records if there are any. A gap
    below zero means that the ranges overlap, so that no threshold separates them.
    """
    level = min(_LEVEL, table.n_level - 1)
    deltas = _deltas(table, level)
    leaks = [tuple((np.flatnonzero(row > 0.0) + 1).tolist()) for row in table.external_coefficients]
    states = {state: [each == state for each in leaks] for state in sorted({(), *leaks})}
    ranges = [{name: span_of(own[rows]) for name, own in deltas.items()} for rows in states.values()]
    quiet = ranges[0]
    gaps = [
        {name: max(own[name][0] - quiet[name][1], quiet[name][0] - own[name][1]) for name in deltas}
        for own in ranges
    ]
    record = [
        {
            "external_leakage_of": list(chambers),
            "runs": sum(rows),
            "ranges_percent": {name: list(map(finite, span)) for name, span in own.items()},
            "gap_percentage_points": {name: finite(gap) for name, gap in apart.items()},
        }
        for (chambers, rows), own, apart in zip(states.items(), ranges, gaps, strict=True)
    ]
    places = [" and ".join(map(str, chambers)) or "none" for chambers in states]
    columns = [
        Column("Out of chamber", places, is_text=True),
        Column("Runs", [*map(sum, states.values())]),
    ]
    for name in deltas:
        texts = [span_text(*map(signed, own[name])) for own in ranges]
        apart = [math.nan, *(each[name] for each in gaps[1:])]
        strong = [k for k, gap in enumerate(apart) if gap > 0.0]
        columns += [Column(f"{name} [%]", texts), Column(f"Gap {name}", apart, text=signed, strong=strong)]
    note = (
        "δ against the fixed, δ′ against the matched baseline. Gap: percentage points between the range and"
        " that of runs without external leakage; below zero they overlap."
    )
    named = any(name.startswith(EXTERNAL) for name in table.data.experiment.baseline)
    lack = "The baseline names no external leakage, so δ does not show it: put"
    said = () if named else (f"{lack} {EXTERNAL}_1: 0 and _2: 0 into the baseline.",)
    title = f"External leakage by the approximation a{level + 1}"
    sheet = Table(tuple(columns), "Ranges over all internal leakages and EBM", "external-ranges", (note,))
    block = Block("external", title, said, (sheet,), is_answer=True)
    return block, {"external_leakage": {"approximation": f"a{level + 1}", "states": record}}


def _deltas(table: RunTable, level: int) -> dict[str, Array]:
    """δ and δ′ [%] of the approximation, and of d2."""
    settled = table.has_settled
    kinds = {
        f"a{level + 1}": (names.SETTLED_APPROXIMATION_RMS if settled else names.APPROXIMATION_RMS, level)
    }
    if level >= _D2:
        kinds["d2"] = (names.SETTLED_DETAIL_RMS if settled else names.DETAIL_RMS, _D2)
    return {
        f"{sign}{name}": table.changes(baseline, rms)[:, at]
        for name, (rms, at) in kinds.items()
        for sign, baseline in (("δ", "fixed"), ("δ′", "matched"))
    }


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
    outside: NDArray[np.bool_]


class ReplicateStudy(NamedTuple):
    """All rows against the replicates of their fixed and of their matched baselines; ranges by β."""

    is_settled: bool
    ranges: list[HealthyRange]
    rows: dict[str, ReplicatedRows]

    @property
    def alarms(self) -> list[Rate]:
        """How often each level has the largest positive δ of a replicate."""
        best = best_levels(np.concatenate([healthy.deltas for healthy in self.ranges]))
        # replicates of one healthy run share their mean, so they depend on each other slightly
        levels = range(self.ranges[0].deltas.shape[1])
        return [clustered_share(best == level, np.arange(len(best))) for level in levels]


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
            row
            for baseline, own in study.rows.items()
            for row in row_records(
                {
                    "run_id": own.rows.texts(names.RUN_ID),
                    "baseline": [baseline] * len(own.rows),
                    "delta_percent": own.deltas,
                    "outside_healthy_range": own.outside,
                }
            )
        ],
        "alarms_on_healthy": {
            f"d{level}": {"alarms": share.count, "of": share.total, "interval_95": [share.low, share.high]}
            for level, share in enumerate(study.alarms, 1)
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
    columns = [Column("Level", [f"d{k + 1}" for k in range(len(study.alarms))], is_text=True)]
    for title, name, is_sealed in (("Leaky", "matched", False), ("Sealed", "fixed", True)):
        own = study.rows[name]
        kept = own.rows.is_sealed == is_sealed
        texts = [f"{n} of {kept.sum()}" for n in own.outside[kept].sum(axis=0).tolist()]
        columns.append(Column(f"{title} outside", texts))
    texts = [share_text(share, with_interval=True) for share in study.alarms]
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
