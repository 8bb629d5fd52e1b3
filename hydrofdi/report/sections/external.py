"""External leakage: δ of an approximation over external leakage, internal leakage and EBM."""

from __future__ import annotations

import math

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.external import ExternalState, ExternalStudy
from hydrofdi.report.ranges import Range
from hydrofdi.report.runs.rows import TableRow
from hydrofdi.report.runs.table import EXTERNAL, SensitivityTable
from hydrofdi.report.sections.doubts import doubt_cells, doubt_columns, doubt_headers, doubt_note
from hydrofdi.report.wording import (
    EXTERNAL_HEADERS,
    HOLE,
    external_cells,
    flow_text,
    joined,
    leakage_label,
    modulus_cell,
    modulus_header,
    signed,
)
from hydrofdi.units import convert


def external_block(analysis: Analysis) -> Block | None:
    """Does the approximation isolate external leakage; None if the experiment does not vary it."""
    study = analysis.external
    if study is None:
        return None
    return Block(
        "external",
        f"External leakage by the approximation {study.name}",
        (
            _legend(study),
            _other_causes(study),
            *_separations(analysis.table, study),
            _mean_sentence(study),
        ),
        (_ranges_sheet(study), _rows_sheet(analysis.table, study)),
    )


def _legend(study: ExternalStudy) -> str:
    return (
        f"δ against the fixed baseline, δ′ against the matched baseline. {study.name} holds the low "
        "frequencies"
        f" of P_1, its mean included; its RMS over {study.gain:.4g}, its gain for a constant, is a pressure."
        " The verdicts and controls below look at the runs without external leakage."
        f" {_window_sentence(study)}"
    )


def _window_sentence(study: ExternalStudy) -> str:
    if study.is_settled:
        return "δ and RMS are those of the settled records."
    return "No record has settled, so δ and RMS contain the start-up transient."


def _other_causes(study: ExternalStudy) -> str:
    inside, modulus = study.effect_of_internal_leakage(), study.effect_of_bulk_modulus()
    return (
        f"Without any leak, the EBM alone gives δ{study.name} {_span(modulus)} %; internal leakage "
        f"alone gives δ′{study.name} {_span(inside)} %."
    )


def _separations(table: SensitivityTable, study: ExternalStudy) -> list[str]:
    if any(name.startswith(EXTERNAL) for name in table.baseline):
        return [_separation(study, state) for state in study.states[1:]]
    return [
        "The baseline names no external leakage, so each healthy run has the external leakage of the "
        f"run that it is compared with, and δ does not show it: put {EXTERNAL}_1: 0 and _2: 0 into "
        "the baseline."
    ]


def _separation(study: ExternalStudy, state: ExternalState) -> str:
    """Which δ have a threshold that separates a state from all runs without external leakage."""
    gaps = {name: gap for name, gap in study.gaps(state).items() if not math.isnan(gap)}
    separated = [f"{name} (a gap of {gap:.1f} points)" for name, gap in gaps.items() if gap > 0.0]
    mixed = [name for name, gap in gaps.items() if gap <= 0.0]
    parts = [f"separated from all runs without by {joined(separated)}"] if separated else []
    parts += [f"not by {joined(mixed)}, whose ranges overlap"] if separated and mixed else []
    parts += (
        [f"separated by none of {joined(mixed)}: their ranges overlap"] if mixed and not separated else []
    )
    lead = f"Leakage out of {_place(state)}, from {flow_text(state.least_flow)} L/min on"
    return f"{lead}, is {'; '.join(parts) or 'not decided'}."


def _mean_sentence(study: ExternalStudy) -> str:
    shares, name = study.mean_shares(), study.name
    if not any(row.status == "ok" for row in study.rows):
        return f"No run has a mean of P_1 to compare {name} with."
    if math.isnan(shares.low):
        return f"{name} is not measured."
    return (
        f"The mean of P_1 makes up {100.0 * shares.low:.0f} to {100.0 * shares.high:.0f} % of the square of"
        f" the RMS of {name}: whatever moves the mean pressure moves {name}."
    )


def _place(state: ExternalState) -> str:
    return f"chamber {state.chambers[0]}" if len(state.chambers) == 1 else "both chambers"


def _span(span: Range) -> str:
    """A range in percent; one number where both ends print alike, a hole if there is none."""
    low, high = signed(span.low), signed(span.high)
    return low if low == high else f"{low} … {high}"


def _ranges_sheet(study: ExternalStudy) -> Sheet:
    rows = []
    for state in study.states:
        place = f"out of {_place(state)}" if state.chambers else "none"
        ranges = study.ranges(state).values()
        rows.append(
            (
                Cell(place),
                Cell(str(len(state.rows))),
                *(Cell(_span(s).replace(" ", "\N{NO-BREAK SPACE}")) for s in ranges),
            )
        )
    headers = ("External leakage", "Runs", *(f"{name} [%]" for name in study.indicators))
    return Sheet(
        "external-ranges",
        "Ranges over all internal leakages and EBM",
        headers,
        tuple(rows),
        text_columns=(0,),
        note="A threshold that separates these runs need not separate others, with a larger internal leakage"
        " or another supply pressure.",
    )


def _rows_sheet(table: SensitivityTable, study: ExternalStudy) -> Sheet:
    return Sheet(
        key="external-rows",
        title=f"{study.name} and d2 of P_1 over external leakage, internal leakage and EBM",
        headers=(
            *EXTERNAL_HEADERS, "Internal [L/min]", modulus_header(),
            f"RMS {study.name}/{study.gain:.4g} [MPa]", "Mean P_1 [MPa]", *study.indicators,
            *doubt_headers(table),
        ),
        rows=tuple((*_lead(row), *_pressures(study, row), *_deltas(study, row), *doubt_cells(table, row))
                   for row in study.rows),
        breaks=group_breaks([row.external.coefficients for row in study.rows]),
        text_columns=doubt_columns(table, 6 + len(study.indicators)),
        note=doubt_note(table),
    )  # fmt: skip


def _lead(row: TableRow) -> list[Cell]:
    return [
        *external_cells(row),
        Cell(leakage_label(row), value=convert(row.leakage_flow, "L/min")),
        modulus_cell(row.bulk_modulus),
    ]


def _pressures(study: ExternalStudy, row: TableRow) -> list[Cell]:
    pressures = (study.approximations(row).rms[study.level] / study.gain, row.mean_pressure)
    return [
        Cell(HOLE if math.isnan(value) else f"{convert(value, 'MPa'):.3f}", value=convert(value, "MPa"))
        for value in pressures
    ]


def _deltas(study: ExternalStudy, row: TableRow) -> list[Cell]:
    values = [of(row) for of in study.indicators.values()]
    return [Cell(signed(value), value=value) for value in values]
