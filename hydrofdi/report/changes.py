"""Sections on the runs: what varied, what is missing, how reliable they are, and δ of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hydrofdi.physics import PHYSICS_VERSION
from hydrofdi.quality.doubts import DOUBTS, REMEDIES, Doubt, doubts_of, samples_per_period
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.axes import Axis
from hydrofdi.report.responses import QUANTILES, strongest_table
from hydrofdi.report.runs import EXTERNAL, RunTable, normal_bulk_modulus
from hydrofdi.report.table import Block, Column, Table, group_breaks
from hydrofdi.report.wording import (
    band_sentence,
    delta_columns,
    doubt_columns,
    doubt_notes,
    kilopascal,
    labels_text,
    lead_columns,
    mode_column,
    modulus_text,
    row_names,
)
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import MISSING, ExperimentData
from hydrofdi.store.layout import names

_MOST_HOLES = 60

MOST_DRAWN = 60
"""Most runs of a heat map of δ."""


def varied_block(analysis: Analysis) -> Block:
    """Parameters with their values, or quantiles of them; runs; and the baseline in words."""
    axes = [found.axis for found in analysis.responses.axes]
    tables = (_values_table([each for each in axes if each.drawn is None]), *_quantiles_table(axes))
    return Block("varied", "What was varied", tuple(_baseline(analysis)), tables)


def summary_block(analysis: Analysis) -> Block:
    """Counts of runs, and what moves most."""
    table = strongest_table(analysis.responses)
    said = filter(None, [*_counts(analysis), analysis.missing_baseline or analysis.no_changes])
    return Block("strongest", "What moves most", tuple(said), (table,), is_answer=True)


def _counts(analysis: Analysis) -> Iterator[str]:
    n_swept = int(analysis.responses.runs.sum())
    n_added = len(analysis.table) - n_swept
    added = f", and {counted(n_added, 'healthy run')} for comparison" if n_added > 0 else ""
    failed = int((~analysis.table.is_ok).sum())
    ended = f"{counted(failed, 'run')} without results" if failed else "all complete"
    yield f"{counted(n_swept, 'run')}{added}; {ended}."


def _baseline(analysis: Analysis) -> Iterator[str]:
    if not analysis.has_baseline:
        yield analysis.missing_baseline
    elif analysis.no_changes:
        yield f"{analysis.no_changes} The tables show the features themselves."
    else:
        yield f"Fixed baseline: {baseline_words(analysis.table, 'fixed')}."
        if "matched" in analysis.baselines:
            yield f"Matched baseline: {baseline_words(analysis.table, 'matched')}."


def _values_table(axes: list[Axis]) -> Table:
    counts = [sorted({int(group.rows.sum()) for group in axis.groups}) for axis in axes]
    ends = [dict.fromkeys((each[0], each[-1])) for each in counts]
    return Table(
        (
            Column("Parameter", [axis.header for axis in axes], is_text=True),
            Column("Values", [", ".join(group.text for group in axis.groups) for axis in axes], is_text=True),
            Column("Runs of each", ["–".join(f"{n:,}" for n in each) for each in ends]),
        ),
        "Parameters by value",
        "varied-values",
    )


def _quantiles_table(axes: list[Axis]) -> Iterator[Table]:
    drawn = [(axis, axis.drawn[np.isfinite(axis.drawn)]) for axis in axes if axis.drawn is not None]
    if drawn:
        texts = [[axis.text(value) for value in np.quantile(known, QUANTILES)] for axis, known in drawn]
        yield Table(
            (
                Column("Parameter", [axis.header for axis, _ in drawn], is_text=True),
                *(Column(f"{100 * q:g} %", [each[k] for each in texts]) for k, q in enumerate(QUANTILES)),
                Column("Runs", [known.size for _, known in drawn]),
            ),
            "Parameters with many values: quantiles over the runs",
            "varied-quantiles",
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


def holes_block(analysis: Analysis) -> Block | None:
    """How many runs have no results, the remedy, and a list of them; None if all runs have results."""
    holes = analysis.table.of(~analysis.table.is_ok)
    if not len(holes):
        return None
    verb = "has" if len(holes) == 1 else "have"
    lead = f"{len(holes):,} of {counted(len(analysis.table), 'run')} {verb} no results."
    shown = holes.of(slice(_MOST_HOLES))
    first = f": the first {len(shown)} of {len(holes):,}" if len(shown) < len(holes) else ""
    table = Table(
        (
            *lead_columns(shown),
            Column("Status", shown.texts(names.STATUS), is_text=True),
            Column("Reason", shown.texts(names.MESSAGE), is_text=True),
        ),
        f"Runs without results{first}",
        "runs-without-results",
    )
    return Block("holes", "What is missing", (lead, *_kinds(holes)), (table,))


def _kinds(holes: RunTable) -> Iterator[str]:
    """How many runs have each status, and what to do about them."""
    for status, n_run in Counter(holes.texts(names.STATUS)).items():
        compute = "hydrofdi sweep CONFIG computes the missing runs and keeps the others"
        what = compute if status == MISSING else REMEDIES.get(status, "")
        yield f"{status}, {counted(n_run, 'run')}" + (f". Remedy: {what}." if what else ".")


def doubts_block(analysis: Analysis) -> Block | None:
    """How many runs have which verdict, by which number, and the remedy; None if all are ok."""
    table = analysis.table
    found = [doubts_of(verdict) for verdict in table.verdicts]
    if not any(found):
        return None
    n_doubtful = sum(map(bool, found))
    verb = "has" if n_doubtful == 1 else "have"
    lines = [f"{n_doubtful} of {counted(len(table), 'run')} {verb} results to read with care:"]
    for doubt in DOUBTS.values():
        own = table.of([doubt in each for each in found])
        if len(own):
            worst = own.of([own[doubt.number].argmax()])
            said = doubt_text(doubt, float(worst[doubt.number][0]), f" ({row_names(worst)[0]})")
            lines.append(f"{doubt.word} ({doubt.mark}), {counted(len(own), 'run')}: {said}")
    return Block("doubts", "How reliable the runs are", tuple(lines))


def doubt_text(doubt: Doubt, share: float, where: str = "") -> str:
    """What a doubt means at its worst number, and the remedy."""
    percent = f"{100.0 * share:.2g}" if share < 0.995 else f"{100.0 * share:.0f}"
    return f"{doubt.meaning.format(percent)}{where}. Remedy: {doubt.remedy}."


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
    state += [labels_text(held)] if held else []
    is_alike = len(held) + len(outside) < len(table.label_names)
    return ", ".join([*state, *(["otherwise the same parameters as the run"] if is_alike else [])])


def changes_block(analysis: Analysis, title: str, key: str) -> Block:
    """The table of all runs for each baseline; the RMS alone if no run has another one as its baseline."""
    table = analysis.table
    if not analysis.baselines:
        title = "RMS of the details of the chamber-1 pressure"
        levels = (
            Column(f"d{k} [kPa]", own, text=kilopascal) for k, own in enumerate(table[names.DETAIL_RMS].T, 1)
        )
        sheet = replace(
            _rows_table(table, *levels), title="RMS of the details of the chamber-1 pressure", key="rms"
        )
        return Block(key, "RMS of the details", (band_sentence(table),), (sheet,))
    legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell."
    if not table.is_sealed.all():
        sealed = "have no internal leakage" if table.varies_external else "are controls"
        legend += f" Rows marked sealed {sealed}."
    tables = tuple(
        _delta_table(analysis, key, "", names.DETAIL_RMS, baseline) for baseline in analysis.baselines
    )
    figures = ("sensitivity",) if len(table) <= MOST_DRAWN else ()
    return Block(key, title, (legend, band_sentence(table)), tables, figures)


def settled_block(analysis: Analysis) -> Block | None:
    """The same table of the settled records; None if no run has settled."""
    if not (analysis.table.has_settled and analysis.baselines):
        return None
    is_periodic = samples_per_period(analysis.data.experiment.nominal_parameters) is not None
    records = (
        "whole periods that agree with the last one, extended periodically"
        if is_periodic
        else "what analysis.discard leaves, whose start may not have settled because the input has no period"
    )
    sentence = (
        f"From the undecimated transform of {records}: independent of the start sample and of an extension."
    )
    tables = tuple(
        _delta_table(analysis, "settled", "Settled: ", names.SETTLED_DETAIL_RMS, each)
        for each in analysis.baselines
    )
    return Block("settled", "The same of settled records, all start phases together", (sentence,), tables)


def _delta_table(analysis: Analysis, key: str, title: str, rms: str, baseline: str) -> Table:
    table = analysis.table
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
