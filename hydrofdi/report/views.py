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
from typing import Any

import numpy as np

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
    if table.data.has_replicates and (view := replicates_view(table, table.data)):
        yield view


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


def replicates_view(table: RunTable, data: ExperimentData) -> View | None:
    """Does a leak move the details more than healthy actuators differ; None if no replicate succeeded."""
    rms = data.columns[names.SETTLED_DETAIL_RMS if table.has_settled else names.DETAIL_RMS]
    deltas, ends, means = _healthy_ranges(rms, data)
    if not deltas:
        return None
    n_level, moduli = rms.shape[1], data.columns[names.BULK_MODULUS]
    columns = [Column("Level", [f"d{k + 1}" for k in range(n_level)], is_text=True)]
    rows: list[dict[str, Any]] = []
    for kind, name, baseline in (
        ("Leaky", "matched", data.matched_baseline),
        ("Sealed", "fixed", data.fixed_baseline),
    ):
        own = table.of(np.isin(baseline[table.positions], [*deltas]))
        against = baseline[own.positions].tolist()
        low, high = np.array([ends[each] for each in against]).reshape(-1, 2, n_level).swapaxes(0, 1)
        healthy = np.array([means[each] for each in against]).reshape(-1, n_level)
        delta = percentage_change(healthy, rms[own.positions])
        outside, kept = (delta < low) | (delta > high), own.is_sealed == (kind == "Sealed")
        texts = [f"{n} of {kept.sum()}" for n in outside[kept].sum(axis=0).tolist()]
        columns.append(Column(f"{kind} outside", texts))
        values = {"delta_percent": delta, "outside_healthy_range": outside}
        lead = {"run_id": own.texts(names.RUN_ID), "baseline": [name] * len(own)}
        rows = row_records(lead | values) + rows
    best = best_levels(np.concatenate([*deltas.values()]))
    # replicates of one healthy run share their mean, so they depend on each other slightly
    alarms = [clustered_share(best == level, np.arange(len(best))) for level in range(n_level)]
    texts = [share_text(share, with_interval=True) for share in alarms]
    columns.append(Column("Largest positive of a replicate", texts))
    counts, spans = [len(each) for each in deltas.values()], np.stack([*ends.values()])
    ranges = (
        modulus_column([float(moduli[position]) for position in deltas]),
        Column("Replicates", counts),
        *(
            Column(f"δd{k + 1}", [span_text(*map(signed, each)) for each in spans[:, :, k].tolist()])
            for k in range(n_level)
        ),
    )
    note = (
        "Outside: runs outside of the range of their healthy replicates; leaky ones against the matched"
        " baseline, sealed ones against the fixed one."
    )
    tables = (
        Table(tuple(columns), "Levels against the healthy replicates", "replicates-levels", (note,)),
        Table(ranges, "δ [%] of replicates, each against the mean of the others", "replicates-ranges"),
    )
    record = {
        "settled": table.has_settled,
        "ranges": [
            {
                "bulk_modulus_MPa": convert(float(moduli[position]), "MPa"),
                "replicates": len(deltas[position]),
                "low_percent": span[0].tolist(),
                "high_percent": span[1].tolist(),
            }
            for position, span in ends.items()
        ],
        "rows": rows,
        "alarms_on_healthy": {
            f"d{level}": {"alarms": share.count, "of": share.total, "interval_95": [share.low, share.high]}
            for level, share in enumerate(alarms, 1)
        },
    }
    title, said = "Healthy replicates: what differs without a leak", tuple(_sentences(table, counts))
    return Block("replicates", title, said, tables), {"replicates": record}


def _healthy_ranges(rms: Array, data: ExperimentData) -> tuple[dict[int, Array], ...]:
    """Healthy run → δ of each replicate against the mean of the others, the ends of δ, the mean; by β."""
    deltas, ends, means = {}, {}, {}
    healthy = np.unique(data.replicate_of[data.replicate_of >= 0])
    order = np.argsort(data.columns[names.BULK_MODULUS][healthy], kind="stable")
    for position in healthy[order].tolist():
        found = rms[data.replicate_of == position]
        found = found[np.isfinite(found).all(axis=1)]
        if len(found) > 1:
            delta = percentage_change((found.sum(axis=0) - found) / (len(found) - 1), found)
            deltas[position], means[position] = delta, found.mean(axis=0)
            ends[position] = np.stack([delta.min(axis=0), delta.max(axis=0)])
    return deltas, ends, means


def _sentences(table: RunTable, counts: list[int]) -> Iterator[str]:
    config, n = table.data.experiment.replicates, max(counts)
    records = "settled records" if table.has_settled else "records as configured"
    over = ", ".join(config.over) or "noise alone"
    yield (
        f"Each healthy run has {counted(n, 'independent replicate')} ({over}; {records}). δ is taken against"
        " their mean; their own range is that of each against the mean of the others. Another healthy one"
        f" would lie outside the range of a level in about 2 of {n + 1} cases."
    )
    if lost := config.count * len(counts) - sum(counts):
        yield f"Left out because they failed or have not settled: {counted(lost, 'replicate')}."
