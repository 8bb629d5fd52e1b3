"""What an experiment varies, and what its runs are compared with."""

from __future__ import annotations

from collections.abc import Iterator

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.runs.axes import Axis
from hydrofdi.report.sections.changes import baseline_words
from hydrofdi.report.sections.quantiles import quantiles_sheet
from hydrofdi.settings.counting import counted


def varied_block(analysis: Analysis) -> Block:
    """Parameters with their values, or quantiles of them; runs; and the baseline in words."""
    axes = [found.axis for found in analysis.responses.axes]
    named = [axis for axis in axes if not axis.is_in_fifths]
    drawn = [axis for axis in axes if axis.is_in_fifths]
    sheets = (_values_sheet(named), _quantiles_sheet(drawn))
    return Block("varied", "What was varied", (*_runs(analysis), *_baseline(analysis)), sheets)


def _runs(analysis: Analysis) -> Iterator[str]:
    n_swept = int(analysis.responses.runs.sum())
    n_added = len(analysis.table.rows) - n_swept
    added = f", and {counted(n_added, 'healthy run')} for comparison" if n_added > 0 else ""
    failed = sum(row.status != "ok" for row in analysis.table.rows)
    ended = f"{counted(failed, 'run')} without results" if failed else "all complete"
    yield f"{counted(n_swept, 'run')}{added}; {ended}."


def _baseline(analysis: Analysis) -> Iterator[str]:
    if not analysis.has_baseline:
        yield analysis.missing_baseline
        return
    if analysis.no_changes:
        yield f"{analysis.no_changes} The tables show the features themselves."
        return
    yield f"Fixed baseline: {baseline_words(analysis.table, 'fixed')}."
    if "matched" in analysis.baselines:
        yield f"Matched baseline: {baseline_words(analysis.table, 'matched')}."
    elif all(row.is_sealed for row in analysis.table.rows):
        yield "No run leaks: each run is its own matched baseline, so δ is shown against the fixed one only."


def _values_sheet(axes: list[Axis]) -> Sheet:
    return Sheet(
        "varied-values",
        "Parameters by value",
        ("Parameter", "Values", "Runs of each"),
        tuple(
            (
                Cell(axis.header),
                Cell(", ".join(group.text for group in axis.groups)),
                Cell(_runs_of_each(axis)),
            )
            for axis in axes
        ),
        text_columns=(0, 1),
    )


def _runs_of_each(axis: Axis) -> str:
    counts = [int(group.rows.sum()) for group in axis.groups]
    return f"{min(counts):,}" if min(counts) == max(counts) else f"{min(counts):,}–{max(counts):,}"


def _quantiles_sheet(axes: list[Axis]) -> Sheet:
    texts = {axis.header: axis.text for axis in axes}
    return quantiles_sheet(
        "varied-quantiles",
        "Parameters with many values: quantiles over the runs",
        "Parameter",
        {axis.header: axis.numbers for axis in axes if axis.numbers is not None},
        lambda header, value: texts[header](value),
    )
