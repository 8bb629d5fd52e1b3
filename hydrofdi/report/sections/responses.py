"""Responses: each feature over the values of each parameter that varies."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hydrofdi.report.analysis import Analysis
from hydrofdi.report.document import Block, Cell, Sheet
from hydrofdi.report.responses import AxisResponses, RankCorrelation, Response, Spread
from hydrofdi.report.wording import HOLE, signed

_GAP = "\N{NO-BREAK SPACE}"


def responses_block(analysis: Analysis) -> Block | None:
    """A table for each axis, and rank correlations of sampled parameters; None where nothing varies."""
    axes = analysis.responses.axes
    shown = [found for found in axes if found.responses]
    if not shown:
        return None
    sheets = tuple(_axis_sheet(found) for found in shown)
    return Block(
        "responses", "Responses", tuple(_legend(shown)), (*sheets, *_rank_sheets(shown)), ("responses",)
    )


def _legend(axes: list[AxisResponses]) -> Iterator[str]:
    yield (
        "Each cell: the median over the runs with that value, and in brackets their range over all else that"
        " varies."
    )
    if any(response.feature.is_change for found in axes for response in found.responses):
        yield "δ: the fall of the RMS of a detail in percent of the healthy RMS, above zero where it fell."


def _axis_sheet(found: AxisResponses) -> Sheet:
    against = f"; δ against {found.against}" if found.against else ""
    return Sheet(
        f"responses-{found.axis.name}",
        f"Over {found.axis.header}{against}",
        ("Feature", *(group.text for group in found.axis.groups)),
        (_runs_row(found), *(_cells(response) for response in found.responses)),
        breaks=(1,),
        text_columns=(0,),
        note="Brackets: 5 to 95 % of the runs." if found.has_quantiles else "Brackets: least and largest.",
    )


def _runs_row(found: AxisResponses) -> tuple[Cell, ...]:
    counts = [int(group.rows.sum()) for group in found.axis.groups]
    return (Cell("runs"), *(Cell(f"{count:,}", value=count) for count in counts))


def _cells(response: Response) -> tuple[Cell, ...]:
    is_change = response.feature.is_change
    return (
        Cell(response.feature.header),
        *(Cell(_spread_text(spread, is_change), value=spread.median) for spread in response.over),
    )


def _spread_text(spread: Spread, is_change: bool) -> str:
    """``+3.7 [+1.9 … +25.2]``; the median alone where all are equal."""
    if math.isnan(spread.median):
        return HOLE
    median, low, high = (_number(value, is_change) for value in (spread.median, spread.low, spread.high))
    return median if low == high == median else f"{median} [{low}…{high}]".replace(" ", _GAP)


def _number(value: float, is_change: bool) -> str:
    return signed(value) if is_change else f"{value:.4g}"


def _rank_sheets(axes: list[AxisResponses]) -> Iterator[Sheet]:
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
            "responses-ranks",
            "Rank correlation of features with sampled parameters",
            ("Feature", "Parameter", "ρ", "95 % interval", "By chance up to", "Runs"),
            tuple(rows),
            text_columns=(0, 1),
            note="Spearman's ρ: +1 where a feature always rises with the parameter, −1 where it always falls."
            " By chance: where a feature does not depend on the parameter, abs(ρ) is below that in 95 % of"
            " cases; marked where it is above. The interval is for independent draws; for a Sobol sequence"
            " or a Latin hypercube it is wider than need be.",
        )


def _rank_cells(rank: RankCorrelation) -> tuple[Cell, ...]:
    if math.isnan(rank.value):
        return Cell(HOLE), Cell(HOLE), Cell(HOLE), Cell(f"{rank.n_run:,}", value=rank.n_run)
    return (
        Cell(f"{rank.value:+.2f}", rank.is_clear, rank.value),
        Cell(f"{rank.low:+.2f}…{rank.high:+.2f}"),
        Cell(f"{rank.chance:.2f}", value=rank.chance),
        Cell(f"{rank.n_run:,}", value=rank.n_run),
    )
