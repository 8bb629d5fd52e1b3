"""Does an approximation separate external leakage from internal leakage and from a change of EBM?

After Goharrizi and Sepehri, International Journal of Fluid Power: they isolate external from internal leakage
by the level-4 approximation. Its RMS is the choice made here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from hydrofdi.report.document import Block, group_breaks
from hydrofdi.report.intervals import span_of
from hydrofdi.report.runs import EXTERNAL, LevelChanges, RunTable, TableRow, finite
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

_LEVEL, _D2 = 3, 1
"""Positions of a4, or the deepest level if there are fewer, and of d2."""

Chambers = tuple[int, ...]
"""Chambers that leak out: 1, 2, both, or none."""


@dataclass(frozen=True)
class ExternalStudy:
    """Rows by external leakage, internal leakage and EBM, and those that leak out of the same chambers.

    δ are those of the settled records if there are any, else of the records as configured.
    """

    level: int
    is_settled: bool
    rows: tuple[TableRow, ...]
    states: dict[Chambers, list[TableRow]]

    @property
    def name(self) -> str:
        """The approximation, e.g. ``a4``."""
        return f"a{self.level + 1}"

    @property
    def gain(self) -> float:
        """What the approximation makes of a constant 1 [-]."""
        return float(2.0 ** ((self.level + 1) / 2.0))

    def approximations(self, row: TableRow) -> LevelChanges:
        """The approximations of a row that are looked at."""
        return row.settled_approximations if self.is_settled else row.approximations

    def deltas(self, row: TableRow) -> dict[str, float]:
        """Name → δ of a row [%]; a prime marks the matched baseline."""
        kinds = {self.name: (self.approximations(row), self.level)}
        if self.level >= _D2:
            kinds["d2"] = (row.settled_details if self.is_settled else row.details, _D2)
        return {
            f"{sign}{name}": levels[level]
            for name, (changes, level) in kinds.items()
            for sign, levels in (("δ", changes.fixed), ("δ′", changes.matched))
        }

    def ranges(self, chambers: Chambers) -> dict[str, tuple[float, float]]:
        """Each δ over the runs of a state."""
        found = [self.deltas(row) for row in self.states[chambers]]
        return {name: span_of([each[name] for each in found]) for name in self.deltas(self.rows[0])}

    def gaps(self, chambers: Chambers) -> dict[str, float]:
        """How far apart each δ keeps a state and the runs without external leakage, in percentage points.

        Negative where they overlap: no threshold separates them.
        """
        quiet, leaky = self.ranges(()), self.ranges(chambers)
        return {name: max(leaky[name][0] - quiet[name][1], quiet[name][0] - leaky[name][1]) for name in leaky}


def study_external(table: RunTable) -> ExternalStudy | None:
    """The study of an experiment that varies external leakage; None for any other."""
    if not table.varies_external:
        return None

    def chambers(row: TableRow) -> Chambers:
        return tuple(chamber for chamber, k in enumerate(row.external_coefficients, 1) if k > 0.0)

    rows = sorted(
        table.rows,
        key=lambda r: (chambers(r), r.external_coefficients, r.leakage_request, r.bulk_modulus),
    )
    states = {group: [row for row in rows if chambers(row) == group]
              for group in sorted({chambers(row) for row in rows} | {()})}  # fmt: skip
    return ExternalStudy(min(_LEVEL, table.n_level - 1), table.has_settled, tuple(rows), states)


def external_record(study: ExternalStudy) -> dict[str, Any]:
    """The study as plain data for JSON."""
    states = [
        {
            "external_leakage_of": list(chambers),
            "runs": len(rows),
            "ranges_percent": {name: [*map(finite, span)] for name, span in study.ranges(chambers).items()},
            "gap_percentage_points": {name: finite(gap) for name, gap in study.gaps(chambers).items()},
        }
        for chambers, rows in study.states.items()
    ]
    return {"external_leakage": {"approximation": study.name, "states": states}}


def external_block(table: RunTable, study: ExternalStudy) -> Block:
    """Does the approximation isolate external leakage."""
    sealed = [study.approximations(row).fixed[study.level] for row in study.states[()] if row.is_sealed]
    inside = [study.approximations(row).matched[study.level] for row in study.states[()] if not row.is_sealed]
    if any(name.startswith(EXTERNAL) for name in table.baseline):
        separations = [_separation(study, chambers) for chambers in study.states if chambers]
    else:
        separations = [
            "The baseline names no external leakage, so δ does not show it: put"
            f" {EXTERNAL}_1: 0 and _2: 0 into the baseline."
        ]
    return Block(
        "external",
        f"External leakage by the approximation {study.name}",
        (
            f"δ against the fixed, δ′ against the matched baseline. {study.name} holds the low frequencies"
            f" of P_1, its mean included; its RMS over its gain, {study.gain:.4g}, is a pressure."
            + ("" if study.is_settled else " No record has settled: δ contain the start-up transient."),
            f"Without a leak, the EBM alone gives δ{study.name} {_span(span_of(sealed))} %; internal leakage"
            f" alone gives δ′{study.name} {_span(span_of(inside))} %.",
            *separations,
        ),
        (_ranges_table(study),),
        is_answer=True,
    )


def _separation(study: ExternalStudy, chambers: Chambers) -> str:
    """Which δ have a threshold that separates a state from all runs without external leakage."""
    gaps = {name: gap for name, gap in study.gaps(chambers).items() if not math.isnan(gap)}
    separated = [f"{name} (a gap of {gap:.1f} points)" for name, gap in gaps.items() if gap > 0.0]
    mixed = [name for name, gap in gaps.items() if gap <= 0.0]
    parts = [f"separated from all runs without by {joined(separated)}"] if separated else []
    parts += [f"not separated by {joined(mixed)}, whose ranges overlap"] if mixed else []
    flows = [row.external_flows[each - 1] for row in study.states[chambers] for each in chambers]
    parts = parts or ["not decided"]
    lead = f"Leakage out of {_place(chambers)}, from {flow_text(span_of(flows)[0])} L/min on"
    return f"{lead}, is {'; '.join(parts)}."


def _place(chambers: Chambers) -> str:
    return f"chamber {chambers[0]}" if len(chambers) == 1 else "both chambers"


def _span(span: tuple[float, float]) -> str:
    return span_text(*map(signed, span))


def _ranges_table(study: ExternalStudy) -> Table:
    ranges = [study.ranges(chambers) for chambers in study.states]
    places = [f"out of {_place(chambers)}" if chambers else "none" for chambers in study.states]
    return Table(
        (
            Column("External leakage", places, is_text=True),
            Column("Runs", [len(rows) for rows in study.states.values()]),
            *(Column(f"{name} [%]", [each[name] for each in ranges], text=_span) for name in ranges[0]),
        ),
        "Ranges over all internal leakages and EBM",
        "external-ranges",
    )


def external_rows_table(study: ExternalStudy) -> Table:
    """Every run, by external leakage, internal leakage and EBM."""
    rows = study.rows
    levels = [study.approximations(row).rms[study.level] / study.gain for row in rows]
    pressures = {
        f"RMS {study.name}/{study.gain:.4g}": levels,
        "Mean P_1": [row.mean_pressure for row in rows],
    }
    deltas = [study.deltas(row) for row in rows]
    columns = (
        *external_columns(rows),
        Column("Internal [L/min]", [leakage_label(row) for row in rows]),
        modulus_column([row.bulk_modulus for row in rows]),
        *(Column(f"{name} [MPa]", values, text=lambda p: hole_or(p, f"{convert(p, 'MPa'):.3f}"))
          for name, values in pressures.items()),
        *(Column(name, [each[name] for each in deltas], text=signed) for name in deltas[0]),
        *doubt_columns(rows),
    )  # fmt: skip
    breaks = group_breaks([row.external_coefficients for row in rows])
    title = f"{study.name} and d2 of P_1 over external leakage, internal leakage and EBM"
    return Table(columns, title, "external-rows", doubt_notes(rows), breaks, n_lead=4)
