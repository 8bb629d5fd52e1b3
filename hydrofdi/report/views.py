"""What an experiment asks for beyond its indicators: external leakage, and how healthy actuators differ.

External leakage: does an approximation separate it from internal leakage and from a change of EBM? After
Goharrizi and Sepehri, International Journal of Fluid Power, who use the level-4 approximation. Its RMS is the
choice made here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.report.document import Block
from hydrofdi.report.indicators import span_of
from hydrofdi.report.runs import EXTERNAL, Array, RunTable, joined, lead_columns, signed, span_text
from hydrofdi.store import names
from hydrofdi.tables.table import Column, Table, finite
from hydrofdi.transforms import percentage_change

View = tuple[Block, dict[str, Any]]

_SEED = "measurement.seed"

_D2, _LEVEL = 1, 3
"""Positions of d2, and of a4; the deepest level if there are fewer."""


def asked_views(table: RunTable) -> Iterator[View]:
    """Sections and data of the varied external leakage, and of what varies without a leak."""
    if table.varies_external:
        yield external_view(table)
    if view := healthy_view(table):
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
    spans = {name: [span_of(own[rows]) for rows in states.values()] for name, own in deltas.items()}
    gaps = {
        name: [max(low - quiet[1], quiet[0] - high) for low, high in (quiet, *others)]
        for name, (quiet, *others) in spans.items()
    }
    record = [
        {
            "external_leakage_of": list(chambers),
            "runs": sum(rows),
            "ranges_percent": {name: list(map(finite, own[index])) for name, own in spans.items()},
            "gap_percentage_points": {name: finite(own[index]) for name, own in gaps.items()},
        }
        for index, (chambers, rows) in enumerate(states.items())
    ]
    places = [" and ".join(map(str, chambers)) or "none" for chambers in states]
    columns = [Column("Out of chamber", places, is_text=True), Column("Runs", [*map(sum, states.values())])]
    for name, own in spans.items():
        apart = [math.nan, *gaps[name][1:]]
        strong = [k for k, gap in enumerate(apart) if gap > 0.0]
        columns.append(Column(f"{name} [%]", [span_text(*map(signed, span)) for span in own]))
        columns.append(Column(f"Gap {name}", apart, text=signed, strong=strong))
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
    kinds = {f"a{level + 1}": (names.APPROXIMATION_RMS, level)}
    if level >= _D2:
        kinds["d2"] = (names.DETAIL_RMS, _D2)
    return {
        f"{sign}{name}": table.changes(baseline, table.settled(rms))[:, at]
        for name, (rms, at) in kinds.items()
        for sign, baseline in (("δ", "fixed"), ("δ′", "matched"))
    }


def healthy_view(table: RunTable) -> View | None:
    """Does a leak move the details more than sealed actuators differ by what is drawn, and by their noise?"""
    sweep = table.data.experiment.sweep
    chance = sweep.drawn | ({_SEED} & {*sweep.names})
    if not chance or chance & {"fluid.bulk_modulus", *INTERNAL_LEAKAGE_FORMS}:
        return None
    labels = tuple(name for name in table.label_names if name not in chance)
    groups = [*_against_sealed(replace(table, label_names=labels))]
    if not groups:
        return None
    first = replace(table.of([rows[0] for rows, _ in groups]), label_names=labels)
    spans = np.array([(delta.min(axis=0), delta.max(axis=0)) for _, delta in groups])
    sealed = spans[np.maximum.accumulate(np.where(first.is_sealed, np.arange(len(first)), 0))]
    beyond = (spans[:, 0] > sealed[:, 1]) | (spans[:, 1] < sealed[:, 0])
    lead = [*lead_columns(first), Column("Runs", [len(rows) for rows, _ in groups])]
    levels = (
        Column(
            f"δd{level} [%]",
            [span_text(*map(signed, ends)) for ends in spans[:, :, level - 1].tolist()],
            strong=np.flatnonzero(beyond[:, level - 1]).tolist(),
        )
        for level in range(1, table.n_level + 1)
    )
    said = (
        f"{'Settled records' if table.has_settled else 'Records'} of actuators that differ in"
        f" {joined(sorted(chance))}. δ is against the mean of the sealed ones; of each of these, against the"
        " mean of the others. Another one would lie outside of the range of n in about 2 of n + 1 cases."
        " Emphasized: the whole range lies outside of that of the sealed ones."
    )
    breaks = np.flatnonzero(first.is_sealed)[1:].tolist()
    sheet = Table((*lead, *levels), "Ranges of δ", "healthy-ranges", breaks=breaks, n_lead=len(lead))
    block = Block("healthy", "Leaks against what differs without a leak", (said,), (sheet,), is_answer=True)
    record = [
        {"run_id": table.of(rows).texts(names.RUN_ID), "delta_percent": delta.tolist()}
        for rows, delta in groups
    ]
    return block, {"healthy_ranges": record}


def _against_sealed(table: RunTable) -> Iterator[tuple[NDArray[np.intp], Array]]:
    """Rows and δ of the sealed runs, then of each leak, where several sealed runs have the same labels."""
    rms = table[table.settled(names.DETAIL_RMS)]
    known, leaks = np.isfinite(rms).all(axis=1), table.leakage_requests
    values = (table[names.BULK_MODULUS].tolist(), *map(table.values, table.label_names))
    conditions = list(zip(*values, strict=True))
    for condition in dict.fromkeys(conditions):
        own = known & np.array([each == condition for each in conditions])
        sealed = rms[own & (leaks == 0.0)]
        for leak in np.unique(leaks[own]) if len(sealed) > 1 else ():
            rows = np.flatnonzero(own & (leaks == leak))
            others = (sealed.sum(axis=0) - sealed) / (len(sealed) - 1)
            yield rows, percentage_change(sealed.mean(axis=0) if leak else others, rms[rows])
