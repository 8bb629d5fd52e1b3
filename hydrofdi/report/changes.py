"""Sections on the runs: what varied, what is missing, how reliable they are, and δ of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hydrofdi.config.shown_values import shown_values
from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.quality.doubts import DOUBTS, REMEDIES, doubts_of
from hydrofdi.quality.measures import samples_per_period
from hydrofdi.report.axes import MOST_VALUES, Axis
from hydrofdi.report.responses import QUANTILES, strongest_table
from hydrofdi.report.runs import EXTERNAL, RunTable, normal_bulk_modulus
from hydrofdi.report.table import Block, Column, Table, group_breaks
from hydrofdi.report.wording import (
    band_sentence,
    delta_columns,
    doubt_columns,
    doubt_notes,
    kilopascal,
    lead_columns,
    mode_column,
    modulus_text,
)
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.store.layout.names import MESSAGE, STATUS, VERDICT

if TYPE_CHECKING:
    from hydrofdi.report.data import ReportData


def varied_block(report: ReportData) -> Block:
    """Parameters with their values, or quantiles of them; runs; and the baseline in words."""
    table = _values_table([found.axis for found in report.responses.axes])
    return Block("varied", "What was varied", tuple(_baseline(report)), (table,))


def summary_block(report: ReportData) -> Block:
    """Counts of runs, and what moves most."""
    n_swept = int(report.responses.runs.sum())
    n_added = len(report.table) - n_swept
    added = f", and {counted(n_added, 'healthy run')} for comparison" if n_added > 0 else ""
    said = (f"{counted(n_swept, 'run')}{added}.", report.no_changes)
    table = strongest_table(report.responses, 3 if report.plane else 6)
    return Block("strongest", "What moves most", tuple(filter(None, said)), (table,), is_answer=True)


def _baseline(report: ReportData) -> Iterator[str]:
    if report.no_changes:
        yield report.no_changes
    for name in report.baselines:
        yield f"{name.capitalize()} baseline: {baseline_words(report.table, name)}."


def _values_table(axes: list[Axis]) -> Table:
    """Values of each parameter, or quantiles of many."""
    ends = [
        [group.text for group in axis.groups]
        if axis.drawn is None
        else map(axis.text, np.nanquantile(axis.drawn, QUANTILES))
        for axis in axes
    ]
    sizes = [[int(group.rows.sum()) for group in axis.groups] for axis in axes]
    counts = [(min(each), max(each)) for each in sizes]
    shares = ", ".join(f"{100 * share:g}" for share in QUANTILES)
    return Table(
        (
            Column("Parameter", [axis.header for axis in axes], is_text=True),
            Column("Values", [", ".join(texts) for texts in ends], is_text=True),
            Column(
                "Runs of each", ["–".join(f"{n:,}" for n in dict.fromkeys((n[0], n[-1]))) for n in counts]
            ),
        ),
        "Parameters by value",
        "varied-values",
        (f"Of more than {MOST_VALUES} values: the {shares} % quantiles, and the runs of each fifth.",)
        if any(axis.drawn is not None for axis in axes)
        else (),
    )


def remarks_block(data: ExperimentData) -> Block | None:
    """Remarks on all runs: another version of the physics, or another request."""
    sentences = [*data.remarks]
    if data.physics_version != PHYSICS_VERSION:
        sentences.append(
            f"Computed with version {data.physics_version} of the physics; this hydrofdi has version"
            f" {PHYSICS_VERSION}, and runs that are computed now may differ."
        )
    return Block("remarks", "Remarks", tuple(sentences)) if sentences else None


def holes_block(data: ExperimentData) -> Block | None:
    """Runs without results by status and reason, with the remedy; None if all runs have results."""
    statuses, messages = (data.columns[name].astype(str).tolist() for name in (STATUS, MESSAGE))
    holes = Counter(each for each in zip(statuses, messages, strict=True) if each[0] != "ok").most_common()
    if not holes:
        return None
    remedies = REMEDIES | {MISSING: "hydrofdi sweep CONFIG computes the missing runs and keeps the others"}
    table = Table(
        (
            Column("Runs", [n_run for _, n_run in holes]),
            Column("Status", [status for (status, _), _ in holes], is_text=True),
            Column("Reason", [why for (_, why), _ in holes], is_text=True),
            Column("Remedy", [remedies.get(status, "") for (status, _), _ in holes], is_text=True),
        ),
        key="runs-without-results",
    )
    lead = f"{sum(n_run for _, n_run in holes):,} of {counted(len(statuses), 'run')} without results."
    return Block("holes", "What is missing", (lead,), (table,), is_answer=True)


def doubts_blocks(data: ExperimentData) -> tuple[Block, ...]:
    """How many runs have which verdict; then what it means, by the worst number, and the remedy."""
    found = [doubts_of(verdict) for verdict in data.columns.get(VERDICT, np.empty(0)).astype(str)]
    rows = []
    for doubt in DOUBTS.values():
        own = np.array([doubt in each for each in found])
        if own.any():
            worst = 100.0 * float(np.nanmax(data.columns[doubt.number][own]))
            meaning = doubt.meaning.format(f"{worst:.2g}" if worst < 99.5 else f"{worst:.0f}")
            rows.append((f"{doubt.word} ({doubt.mark})", int(own.sum()), meaning, doubt.remedy))
    if not rows:
        return ()
    n_run = counted(len(found), "run")
    said = f"To be read with care, of {n_run}: {', '.join(f'{n:,} {word}' for word, n, *_ in rows)}."
    columns = dict(zip(("Verdict", "Runs", "Meaning", "Remedy"), zip(*rows, strict=True), strict=True))
    table = Table.of(columns, key="doubts")
    return (
        Block("verdicts", "Verdicts", (said,), is_answer=True),
        Block("doubts", "How reliable the runs are", (), (table,)),
    )


def baseline_title(table: RunTable, baseline: str) -> str:
    """What δ is taken against, as a title."""
    return f"δ [%] against the {baseline} baseline ({baseline_words(table, baseline)})"


def baseline_words(table: RunTable, baseline: str) -> str:
    """The conditions of the fixed or the matched baseline."""
    conditions = table.data.experiment.baseline
    held = {name: conditions[name] for name in table.label_names if name in conditions}
    outside = {name: held.pop(name) for name in list(held) if name.startswith(EXTERNAL)}
    sealed = "sealed internally and externally" if outside and not any(outside.values()) else "sealed"
    if baseline == "matched":
        return f"{sealed}, the same conditions as the run"
    state = [sealed, f"EBM {modulus_text(normal_bulk_modulus(table.data))}"]
    state += [shown_values(held)] if held else []
    is_alike = len(held) + len(outside) < len(table.label_names)
    return ", ".join([*state, *(["otherwise the same parameters as the run"] if is_alike else [])])


def changes_block(report: ReportData, title: str, key: str) -> Block:
    """The table of all runs for each baseline; the RMS alone if no run has another one as its baseline."""
    table = report.table
    if not report.baselines:
        return Block(key, "RMS of the details", (band_sentence(table),), (rms_table(table),))
    legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell."
    if not table.is_sealed.all():
        sealed = "have no internal leakage" if table.varies_external else "are controls"
        legend += f" Rows marked sealed {sealed}."
    tables = tuple(_delta_table(report, key, "", names.DETAIL_RMS, baseline) for baseline in report.baselines)
    return Block(key, title, (legend, band_sentence(table)), tables)


def rms_table(table: RunTable) -> Table:
    """The RMS of the details of each run."""
    levels = enumerate(table[names.DETAIL_RMS].T, 1)
    columns = (Column(f"d{k} [kPa]", own, text=kilopascal) for k, own in levels)
    return replace(
        _rows_table(table, *columns), title="RMS of the details of the chamber-1 pressure", key="rms"
    )


def settled_block(report: ReportData) -> Block | None:
    """The same table of the settled records; None if no run has settled."""
    if not (report.table.has_settled and report.baselines):
        return None
    is_periodic = samples_per_period(report.data.experiment.nominal_parameters) is not None
    records = (
        "whole periods that agree with the last one, extended periodically"
        if is_periodic
        else "what analysis.discard leaves, whose start may not have settled because the input has no period"
    )
    sentence = (
        f"From the undecimated transform of {records}: independent of the start sample and of an extension."
    )
    tables = tuple(
        _delta_table(report, "settled", "Settled: ", names.SETTLED_DETAIL_RMS, each)
        for each in report.baselines
    )
    return Block("settled", "The same of settled records, all start phases together", (sentence,), tables)


def _delta_table(report: ReportData, key: str, title: str, rms: str, baseline: str) -> Table:
    table = report.table
    breaks = group_breaks(table.leakage_requests.tolist())
    return replace(
        _rows_table(table, *delta_columns(table.changes(baseline, rms))),
        title=f"{title}{baseline_title(table, baseline)}",
        key=f"{key}-{baseline}",
        breaks=breaks if len(breaks) < len(table) - 1 else (),
    )


def _rows_table(table: RunTable, *columns: Column) -> Table:
    """Columns between what a run is and its verdict."""
    lead = [*lead_columns(table), mode_column(table)]
    content = (*lead, *columns, *doubt_columns(table))
    return Table(content, notes=doubt_notes(table), n_lead=len(lead))
