"""Rows against healthy replicates, beside the range that these span themselves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.replicates import HealthyRange, ReplicatedRow, ReplicateStudy
from hydrofdi.report.wording import (
    HOLE,
    lead_cells,
    lead_headers,
    modulus_cell,
    modulus_header,
    share_text,
    signed,
)
from hydrofdi.settings.counting import counted


def replicates_block(analysis: Analysis, levels: Sequence[int] | None = None) -> Block | None:
    """Does a leak move the details more than healthy actuators differ; None without replicates.

    Parameters
    ----------
    analysis : Analysis
    levels : sequence of int, optional
        Positions of the levels that the sentences are about; by default all.
    """
    study = analysis.replicates
    if study is None:
        return None
    return Block(
        "replicates",
        "Healthy replicates: what differs without a leak",
        tuple(_sentences(analysis, study, levels or range(analysis.table.n_level))),
        (
            _ranges_sheet(analysis, study.ranges),
            _rows_sheet(analysis, "matched", "the matched baseline", study.matched),
            _rows_sheet(analysis, "fixed", "the fixed baseline", study.fixed),
        ),
    )


def _sentences(analysis: Analysis, study: ReplicateStudy, levels: Sequence[int]) -> Iterator[str]:
    config = analysis.data.experiment.replicates
    over = ", ".join(config.over) or "the noise of the sensors alone"
    n = max(healthy.n_replicate for healthy in study.ranges)
    records = "settled records" if study.is_settled else "records as configured"
    yield (
        f"Each healthy run has {counted(n, 'independent replicate')} ({over}; {records}). δ is taken against"
        " their mean; their own range is that of each against the mean of the others. Another healthy "
        f"actuator would lie outside the range of a level in about 2 of {n + 1} cases."
    )
    lost = sum(config.count - healthy.n_replicate for healthy in study.ranges)
    if lost:
        yield (
            f"Left out because they failed or have not settled: {lost} of "
            f"{counted(config.count * len(study.ranges), 'replicate')}. The"
            " ranges lack what these would add."
        )
    for level in levels:
        yield _outside_sentence(study, level)
    for level in levels:
        share = share_text(study.alarms(level), with_interval=True)
        yield f"“δd{level + 1} is the largest positive” holds for {share} of the healthy replicates."


def _outside_sentence(study: ReplicateStudy, level: int) -> str:
    leaky = [entry for entry in study.matched if not entry.row.is_sealed]
    sealed = [entry for entry in study.fixed if entry.row.is_sealed]
    found = sum(entry.outside[level] for entry in leaky)
    alarmed = sum(entry.outside[level] for entry in sealed)
    return (
        f"δd{level + 1} lies outside of the healthy range in {found} of {counted(len(leaky), 'leaky run')}"
        f" against the matched baseline, and in {alarmed} of {counted(len(sealed), 'sealed run')} "
        "against the fixed baseline."
    )


def _level_headers(n_level: int) -> list[str]:
    return [f"δd{level}" for level in range(1, n_level + 1)]


def _ranges_sheet(analysis: Analysis, ranges: Sequence[HealthyRange]) -> Sheet:
    rows = [
        (
            modulus_cell(healthy.bulk_modulus),
            Cell(str(healthy.n_replicate)),
            *(
                Cell(f"{signed(low)} … {signed(high)}".replace(" ", "\N{NO-BREAK SPACE}"))
                for low, high in zip(healthy.low, healthy.high, strict=True)
            ),
        )
        for healthy in ranges
    ]
    return Sheet(
        "replicates-ranges",
        "δ [%] of the healthy replicates, each against the mean of the others",
        (modulus_header(), "Replicates", *_level_headers(analysis.table.n_level)),
        tuple(rows),
    )


def _rows_sheet(analysis: Analysis, key: str, baseline: str, entries: Sequence[ReplicatedRow]) -> Sheet:
    rows = [
        (
            *lead_cells(analysis.table, entry.row),
            *(
                Cell(signed(value) if value == value else HOLE, outside, value)
                for value, outside in zip(entry.delta, entry.outside, strict=True)
            ),
        )
        for entry in entries
    ]
    return Sheet(
        f"replicates-{key}",
        f"δ [%] against the mean of the replicates of {baseline}",
        (*lead_headers(analysis.table), *_level_headers(analysis.table.n_level)),
        tuple(rows),
        breaks=group_breaks([entry.row.leakage_request for entry in entries]),
        note="Marked: outside the range of the healthy replicates.",
    )
