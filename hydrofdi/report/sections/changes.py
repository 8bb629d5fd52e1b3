"""δ of all runs against both baselines, as configured and of the settled records."""

from __future__ import annotations

from collections.abc import Callable

from hydrofdi.quality.settling import samples_per_period
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Rows, Sheet, group_breaks
from hydrofdi.report.runs.rows import Levels, TableRow
from hydrofdi.report.runs.table import EXTERNAL, SensitivityTable
from hydrofdi.report.sections.doubts import doubt_cells, doubt_columns, doubt_headers, doubt_note
from hydrofdi.report.wording import (
    band_sentence,
    delta_cells,
    kilopascal,
    labels_text,
    lead_cells,
    lead_headers,
    modulus_text,
)

BASELINES: dict[str, Callable[[TableRow], Levels]] = {
    "fixed": lambda row: row.delta_fixed,
    "matched": lambda row: row.delta_matched,
}
"""Kind of baseline → δ of a row against it."""

SETTLED: dict[str, Callable[[TableRow], Levels]] = {
    "fixed": lambda row: row.settled_details.fixed,
    "matched": lambda row: row.settled_details.matched,
}
"""The same of the settled record."""


_CIRCLES = (
    "From the undecimated transform of whole periods that agree with the last one, extended periodically."
)
_RECORDS = (
    "The input has no period, so settling is not judged and the start of the record is included: from"
    " the undecimated transform of what analysis.discard leaves, without the coefficients that reach"
    " beyond its start."
)
_NO_PHASE = "It depends neither on the start sample of the record nor on an extension."


def baseline_title(table: SensitivityTable, baseline: str) -> str:
    """What δ is taken against, as a title."""
    name = "matched baseline" if baseline == "matched" else "fixed baseline"
    return f"δ [%] against the {name} ({baseline_words(table, baseline)})"


def baseline_words(table: SensitivityTable, baseline: str) -> str:
    """The conditions of the fixed or the matched baseline."""
    held = {name: table.baseline[name] for name in table.label_names if name in table.baseline}
    outside = {name: held.pop(name) for name in list(held) if name.startswith(EXTERNAL)}
    sealed = "sealed internally and externally" if outside and not any(outside.values()) else "sealed"
    if baseline == "matched":
        return f"{sealed}, the same conditions as the run"
    state = [sealed, f"EBM {modulus_text(table.normal_bulk_modulus)}"]
    state += [labels_text(held)] if held else []
    state += (
        ["otherwise the same parameters as the run"]
        if len(held) + len(outside) < len(table.label_names)
        else []
    )
    return ", ".join(state)


def changes_block(
    analysis: Analysis, title: str = "Change of the details over the varied parameters", key: str = "changes"
) -> Block:
    """The table of all runs for each baseline; the RMS alone if no run has another one as its baseline."""
    table = analysis.table
    if not analysis.baselines:
        return Block(key, "RMS of the details", (band_sentence(table),), (_rms_sheet(table),))
    return Block(
        key,
        title,
        (_legend(analysis), band_sentence(table)),
        _sheets(analysis, key, "", BASELINES),
        ("sensitivity",),
    )


def _legend(analysis: Analysis) -> str:
    table = analysis.table
    legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell."
    if not all(row.is_sealed for row in table.rows):
        sealed = "have no internal leakage" if table.varies_external else "are controls"
        own = "; a sealed row is its own matched baseline, so its zeros there test nothing"
        legend += f" Rows marked sealed {sealed}{own if 'matched' in analysis.baselines else ''}."
    return legend


def _sheets(
    analysis: Analysis, key: str, title: str, baselines: dict[str, Callable[[TableRow], Levels]]
) -> tuple[Sheet, ...]:
    """The table of all runs for each baseline of `Analysis.baselines`."""
    return tuple(
        _sheet(analysis, f"{key}-{name}", f"{title}{baseline_title(analysis.table, name)}", baselines[name])
        for name in analysis.baselines
    )


def _rms_sheet(table: SensitivityTable) -> Sheet:
    levels = [f"d{level} [kPa]" for level in range(1, table.n_level + 1)]
    return Sheet(
        key="rms",
        title="RMS of the details of the chamber-1 pressure",
        headers=(*lead_headers(table), *levels, *doubt_headers(table)),
        rows=tuple(
            (
                *lead_cells(table, row),
                *(Cell(kilopascal(rms), value=rms) for rms in row.detail_rms),
                *doubt_cells(table, row),
            )
            for row in table.rows
        ),
        text_columns=doubt_columns(table, len(lead_headers(table)) + table.n_level),
        note=doubt_note(table),
        n_lead=len(lead_headers(table)),
    )


def settled_block(analysis: Analysis) -> Block | None:
    """The same table of the settled records; None if no run has settled."""
    if not (analysis.table.has_settled and analysis.baselines):
        return None
    is_periodic = samples_per_period(analysis.data.experiment.nominal_parameters) is not None
    return Block(
        "settled",
        f"The same, {'settled: no start-up transient' if is_periodic else 'undecimated'}, all start "
        "phases, no boundaries",
        (_CIRCLES if is_periodic else _RECORDS, _NO_PHASE),
        _sheets(analysis, "settled", "Settled: ", SETTLED),
    )


def _sheet(analysis: Analysis, key: str, title: str, delta: Callable[[TableRow], Levels]) -> Sheet:
    table = analysis.table
    levels = [f"δd{level}" for level in range(1, table.n_level + 1)]
    return Sheet(
        key=key,
        title=title,
        headers=(*lead_headers(table), *levels, *doubt_headers(table)),
        rows=Rows(
            table.rows,
            lambda row: (*lead_cells(table, row), *delta_cells(delta(row)), *doubt_cells(table, row)),
        ),
        breaks=_breaks(table),
        text_columns=doubt_columns(table, len(lead_headers(table)) + table.n_level),
        note=doubt_note(table),
        n_lead=len(lead_headers(table)),
    )


def _breaks(table: SensitivityTable) -> tuple[int, ...]:
    """Where another leakage begins; nowhere if each row has its own."""
    breaks = group_breaks([row.leakage_request for row in table.rows])
    return breaks if len(breaks) < len(table.rows) - 1 else ()
