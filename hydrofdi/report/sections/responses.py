"""Responses: each feature over the values of each parameter that varies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.responses import AxisResponses, RankCorrelation, Response, Spread
from hydrofdi.report.wording import HOLE, signed, with_minus

_GAP = "\N{NO-BREAK SPACE}"


def responses_blocks(analysis: Analysis) -> tuple[Block, ...]:
    """Details of P_1, then further indicators: a table for each axis, and rank correlations."""
    axes = analysis.responses.axes
    details, measured = ([_part(found, is_detail=is_detail) for found in axes] for is_detail in (True, False))
    blocks = [
        *_blocks("responses", "Responses of the details", details),
        *_blocks("responses-indicators", "Responses of further indicators", measured),
    ]
    return (replace(blocks[0], figures=("responses",)), *blocks[1:]) if blocks else ()


def _part(found: AxisResponses, *, is_detail: bool) -> AxisResponses:
    kept = [response for response in found.responses if response.feature.is_detail == is_detail]
    return replace(found, against=found.against if is_detail else "", responses=tuple(kept))


def _blocks(key: str, title: str, axes: list[AxisResponses]) -> Iterator[Block]:
    shown = [found for found in axes if found.responses]
    if shown:
        sheets = tuple(_axis_sheet(key, found) for found in shown)
        yield Block(key, title, tuple(_legend(shown)), (*sheets, *_rank_sheets(key, shown)))


def _legend(axes: list[AxisResponses]) -> Iterator[str]:
    if any(_has_ranges(found) for found in axes):
        yield (
            "Each cell: the median of the runs with that value and, in brackets, their range over all other "
            "parameters."
        )
    else:
        yield "Each cell: the run with that value."
    if any(response.feature.is_change for found in axes for response in found.responses):
        yield "δ: the fall of the RMS of a detail in percent of the healthy RMS, positive if it fell."


def _axis_sheet(key: str, found: AxisResponses) -> Sheet:
    against = f"; δ against {found.against}" if found.against else ""
    return Sheet(
        f"{key}-{found.axis.name}",
        f"Over {found.axis.header}{against}",
        ("Feature", *(group.text for group in found.axis.groups)),
        (_runs_row(found), *(_cells(response, _known(found)) for response in found.responses)),
        text_columns=(0,),
        note=_note(found),
    )


def _has_ranges(found: AxisResponses) -> bool:
    """Whether any value belongs to several runs."""
    return any(group.rows.sum() > 1 for group in found.axis.groups)


def _note(found: AxisResponses) -> str:
    if not _has_ranges(found):
        return ""
    return "Brackets: 5 to 95 % of the runs." if found.has_quantiles else "Brackets: minimum and maximum."


def _runs_row(found: AxisResponses) -> tuple[Cell, ...]:
    """Runs that have a number, and of how many where some have none."""
    counts = [int(group.rows.sum()) for group in found.axis.groups]
    pairs = zip(_known(found), counts, strict=True)
    texts = (f"{known:,} of {count:,}" if known < count else f"{count:,}" for known, count in pairs)
    return (Cell("runs"), *(Cell(text, value=n) for text, n in zip(texts, _known(found), strict=True)))


def _known(found: AxisResponses) -> list[int]:
    """Runs of each group that any feature has a number of."""
    spreads = zip(*(response.over for response in found.responses), strict=True)
    return [max(spread.n_run for spread in of_group) for of_group in spreads]


def _cells(response: Response, known: list[int]) -> tuple[Cell, ...]:
    """The spread over each group, with its number of runs where other features have more."""
    is_change = response.feature.is_change
    texts = (
        _spread_text(spread, is_change)
        + (f"{_GAP}(n{_GAP}={_GAP}{spread.n_run})" if spread.n_run < n else "")
        for spread, n in zip(response.over, known, strict=True)
    )
    medians = (spread.median for spread in response.over)
    return (Cell(response.feature.header), *map(_cell, texts, medians))


def _cell(text: str, value: float) -> Cell:
    return Cell(text, value=value)


def _spread_text(spread: Spread, is_change: bool) -> str:
    """``+3.7 [+1.9 … +25.2]``; the median alone where all are equal."""
    if math.isnan(spread.median):
        return HOLE
    median, low, high = (_number(value, is_change) for value in (spread.median, spread.low, spread.high))
    return median if low == high == median else f"{median} [{low}…{high}]".replace(" ", _GAP)


def _number(value: float, is_change: bool) -> str:
    return signed(value) if is_change else with_minus(f"{value:.4g}")


def _rank_sheets(key: str, axes: list[AxisResponses]) -> Iterator[Sheet]:
    """Rank correlations of all features with the parameters that have many values."""
    ranked = [found for found in axes if found.axis.is_in_fifths]
    rows = [
        (Cell(response.feature.name), Cell(found.axis.name), *_rank_cells(response.rank))
        for found in ranked
        for response in found.responses
        if response.rank is not None
    ]
    if rows:
        yield Sheet(
            f"{key}-ranks",
            "Rank correlation of features with sampled parameters",
            ("Feature", "Parameter", "ρ", "95 % interval", "By chance up to", "Runs"),
            tuple(rows),
            text_columns=(0, 1),
            note="Spearman's ρ: +1 if a feature always rises with the parameter, −1 if it always falls. "
            "By chance: if a feature does not depend on the parameter, abs(ρ) is below this in 95 % "
            "of cases; larger ones are marked. The interval is for independent draws; for a Sobol "
            "sequence"
            " or a Latin hypercube it is wider than necessary.",
        )


def _rank_cells(rank: RankCorrelation) -> tuple[Cell, ...]:
    if math.isnan(rank.value):
        return Cell(HOLE), Cell(HOLE), Cell(HOLE), Cell(f"{rank.n_run:,}", value=rank.n_run)
    return (
        Cell(signed(rank.value, 2), rank.is_clear, rank.value),
        Cell(f"{signed(rank.low, 2)}…{signed(rank.high, 2)}"),
        Cell(f"{rank.chance:.2f}", value=rank.chance),
        Cell(f"{rank.n_run:,}", value=rank.n_run),
    )
