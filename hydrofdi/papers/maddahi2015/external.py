"""Does an approximation separate external leakage from internal leakage and from a change of EBM?

After Goharrizi and Sepehri, International Journal of Fluid Power: they isolate external from internal leakage
by the level-4 approximation. Its RMS is the choice made here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hydrofdi.papers.maddahi2015.claims import D2
from hydrofdi.report.composition import View
from hydrofdi.report.document import Block
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.intervals import span_of
from hydrofdi.report.runs import EXTERNAL, Array, RunTable
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import signed, span_text
from hydrofdi.store.layout import names

_LEVEL = 3
"""Position of a4; the deepest level if there are fewer."""


def external_views(table: RunTable) -> Iterator[View]:
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
    yield block, {"external_leakage": {"approximation": f"a{level + 1}", "states": record}}


def _deltas(table: RunTable, level: int) -> dict[str, Array]:
    """δ and δ′ [%] of the approximation, and of d2."""
    settled = table.has_settled
    kinds = {
        f"a{level + 1}": (names.SETTLED_APPROXIMATION_RMS if settled else names.APPROXIMATION_RMS, level)
    }
    if level >= D2:
        kinds["d2"] = (names.SETTLED_DETAIL_RMS if settled else names.DETAIL_RMS, D2)
    return {
        f"{sign}{name}": table.changes(baseline, rms)[:, at]
        for name, (rms, at) in kinds.items()
        for sign, baseline in (("δ", "fixed"), ("δ′", "matched"))
    }
