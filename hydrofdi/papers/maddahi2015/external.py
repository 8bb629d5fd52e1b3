"""Does an approximation separate external leakage from internal leakage and from a change of EBM?

After Goharrizi and Sepehri, International Journal of Fluid Power: they isolate external from internal leakage
by the level-4 approximation. Its RMS is the choice made here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from hydrofdi.papers.maddahi2015.claims import D2
from hydrofdi.report.composition import View
from hydrofdi.report.document import Block, group_breaks
from hydrofdi.report.intervals import span_of
from hydrofdi.report.runs import EXTERNAL, LevelChanges, RunTable, TableRow
from hydrofdi.report.table import Column, Table
from hydrofdi.report.wording import (
    doubt_columns,
    doubt_notes,
    external_columns,
    flow_text,
    hole_or,
    joined,
    leakage_label,
    modulus_column,
    signed,
    span_text,
)
from hydrofdi.units import convert

_LEVEL = 3
"""Position of a4; the deepest level if there are fewer."""

Chambers = tuple[int, ...]
"""Chambers that leak out: 1, 2, both, or none."""


@dataclass(frozen=True)
class ExternalStudy:
    """Rows by external leakage, internal leakage and EBM, and where those of the same leaky chambers are.

    `deltas` are name → δ of each row [%], a prime for the matched baseline: of the settled records if there
    are any, else of the records as configured.
    """

    level: int
    is_settled: bool
    rows: tuple[TableRow, ...]
    states: dict[Chambers, list[int]]
    approximations: list[LevelChanges]
    deltas: dict[str, list[float]]

    @property
    def name(self) -> str:
        """The approximation, e.g. ``a4``."""
        return f"a{self.level + 1}"

    @property
    def gain(self) -> float:
        """What the approximation makes of a constant 1 [-]."""
        return float(2.0 ** ((self.level + 1) / 2.0))

    def ranges(self, chambers: Chambers) -> dict[str, tuple[float, float]]:
        """Each δ over the runs of a state."""
        own = self.states[chambers]
        return {name: span_of([values[k] for k in own]) for name, values in self.deltas.items()}

    def gaps(self, chambers: Chambers) -> dict[str, float]:
        """How far apart each δ keeps a state and the runs without external leakage, in percentage points.

        Negative where they overlap: no threshold separates them.
        """
        quiet, leaky = self.ranges(()), self.ranges(chambers)
        return {name: max(leaky[name][0] - quiet[name][1], quiet[name][0] - leaky[name][1]) for name in leaky}


def study_external(table: RunTable) -> ExternalStudy:
    """The study of an experiment that varies external leakage."""
    rows = sorted(
        table.rows, key=lambda r: (_chambers(r), r.external_coefficients, r.leakage_request, r.bulk_modulus)
    )
    found: dict[Chambers, list[int]] = {(): []}
    for k, row in enumerate(rows):
        found.setdefault(_chambers(row), []).append(k)
    level, settled = min(_LEVEL, table.n_level - 1), table.has_settled
    approximations = [row.settled_approximations if settled else row.approximations for row in rows]
    kinds = {f"a{level + 1}": (approximations, level)}
    if level >= D2:
        kinds["d2"] = ([row.settled_details if settled else row.details for row in rows], D2)
    deltas = {
        f"{sign}{name}": [getattr(each, baseline)[k] for each in changes]
        for name, (changes, k) in kinds.items()
        for sign, baseline in (("δ", "fixed"), ("δ′", "matched"))
    }
    return ExternalStudy(level, settled, tuple(rows), found, approximations, deltas)


def _chambers(row: TableRow) -> Chambers:
    return tuple(chamber for chamber, k in enumerate(row.external_coefficients, 1) if k > 0.0)


def external_views(table: RunTable) -> Iterator[View]:
    """Does the approximation isolate external leakage; and every run."""
    study = study_external(table)
    states = [
        {
            "external_leakage_of": list(chambers),
            "runs": len(rows),
            "ranges_percent": {
                name: list(map(_finite, span)) for name, span in study.ranges(chambers).items()
            },
            "gap_percentage_points": {name: _finite(gap) for name, gap in study.gaps(chambers).items()},
        }
        for chambers, rows in study.states.items()
    ]
    title = f"External leakage by the approximation {study.name}"
    block = Block("external", title, tuple(_sentences(table, study)), (_ranges_table(study),), is_answer=True)
    yield block, {"external_leakage": {"approximation": study.name, "states": states}}
    yield Block("external-rows", "Runs by external leakage", (), (_rows_table(study),)), {}


def _sentences(table: RunTable, study: ExternalStudy) -> Iterator[str]:
    sealed = [k for k in study.states[()] if study.rows[k].is_sealed]
    inside = [k for k in study.states[()] if not study.rows[k].is_sealed]
    fixed, matched = (
        span_of([study.deltas[f"{sign}{study.name}"][k] for k in own])
        for sign, own in (("δ", sealed), ("δ′", inside))
    )
    yield (
        f"δ against the fixed, δ′ against the matched baseline. {study.name} holds the low frequencies"
        f" of P_1, its mean included; its RMS over its gain, {study.gain:.4g}, is a pressure."
        + ("" if study.is_settled else " No record has settled: δ contain the start-up transient.")
    )
    yield (
        f"Without a leak, the EBM alone gives δ{study.name} {_span(fixed)} %; internal leakage"
        f" alone gives δ′{study.name} {_span(matched)} %."
    )
    if any(name.startswith(EXTERNAL) for name in table.baseline):
        yield from (_separation(study, chambers) for chambers in study.states if chambers)
    else:
        yield (
            "The baseline names no external leakage, so δ does not show it: put"
            f" {EXTERNAL}_1: 0 and _2: 0 into the baseline."
        )


def _separation(study: ExternalStudy, chambers: Chambers) -> str:
    """Which δ have a threshold that separates a state from all runs without external leakage."""
    gaps = {name: gap for name, gap in study.gaps(chambers).items() if not math.isnan(gap)}
    separated = [f"{name} (a gap of {gap:.1f} points)" for name, gap in gaps.items() if gap > 0.0]
    mixed = [name for name, gap in gaps.items() if gap <= 0.0]
    parts = [f"separated from all runs without by {joined(separated)}"] if separated else []
    parts += [f"not separated by {joined(mixed)}, whose ranges overlap"] if mixed else []
    flows = [study.rows[k].external_flows[each - 1] for k in study.states[chambers] for each in chambers]
    lead = f"Leakage out of {_place(chambers)}, from {flow_text(span_of(flows)[0])} L/min on"
    return f"{lead}, is {'; '.join(parts) or 'not decided'}."


def _place(chambers: Chambers) -> str:
    return f"chamber {chambers[0]}" if len(chambers) == 1 else "both chambers"


def _span(span: tuple[float, float]) -> str:
    return span_text(*map(signed, span))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _ranges_table(study: ExternalStudy) -> Table:
    ranges = [study.ranges(chambers) for chambers in study.states]
    places = [f"out of {_place(chambers)}" if chambers else "none" for chambers in study.states]
    columns = (
        Column("External leakage", places, is_text=True),
        Column("Runs", [len(rows) for rows in study.states.values()]),
        *(Column(f"{name} [%]", [each[name] for each in ranges], text=_span) for name in study.deltas),
    )
    return Table(columns, "Ranges over all internal leakages and EBM", "external-ranges")


def _rows_table(study: ExternalStudy) -> Table:
    """Every run, by external leakage, internal leakage and EBM."""
    rows = study.rows
    pressures = {
        f"RMS {study.name}/{study.gain:.4g}": [e.rms[study.level] / study.gain for e in study.approximations],
        "Mean P_1": [row.mean_pressure for row in rows],
    }
    columns = (
        *external_columns(rows),
        Column("Internal [L/min]", [leakage_label(row) for row in rows]),
        modulus_column([row.bulk_modulus for row in rows]),
        *(Column(f"{name} [MPa]", values, text=lambda p: hole_or(p, f"{convert(p, 'MPa'):.3f}"))
          for name, values in pressures.items()),
        *(Column(name, values, text=signed) for name, values in study.deltas.items()),
        *doubt_columns(rows),
    )  # fmt: skip
    breaks = group_breaks([row.external_coefficients for row in rows])
    title = f"{study.name} and d2 of P_1 over external leakage, internal leakage and EBM"
    return Table(columns, title, "external-rows", doubt_notes(rows), breaks, n_lead=4)
