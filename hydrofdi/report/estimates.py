"""The section on estimates: their errors, and whether their intervals cover the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.evaluation.rates import Rate
from hydrofdi.report.table import Block, Column, Table, finite, group_breaks
from hydrofdi.report.wording import hole_or, joined
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.truth import EstimateJudgement, Estimates
from hydrofdi.units import convert

REFERENCE_PRESSURE = 8e6
"""Pressure difference at which K_i is shown as a flow [Pa]."""

_NAMES = {"internal_coefficient": "leakage [L/min]", "bulk_modulus": "β [% of the truth]"}
_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(estimates: Estimates) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    rows = estimates.judgements
    if not rows:
        return None
    level = f"{100.0 * estimates.confidence:g} %"
    numbers = {"Mean error": "bias", "1σ of errors": "deviation", "1σ stated": "stated"}
    columns = (
        Column("Indicator", [each.indicator for each in rows], is_text=True),
        Column("Estimate", [_NAMES[each.quantity] for each in rows], is_text=True),
        Column("Population", [each.population for each in rows], is_text=True),
        *(
            Column(
                title,
                [_shown(each.quantity, getattr(each, name)) for each in rows],
                text=lambda value: hole_or(value, two_digits(value)),
            )
            for title, name in numbers.items()
        ),
        Column("Covered [%]", [each.covered if each.n else None for each in rows], text=_share_text),
    )
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_PRESSURE / 1e6:g} MPa. 1σ stated: root mean square. Covered:"
        f" records whose stated {level} interval contains the truth, with the {level} interval of that share."
        f"{_left_out(estimates)}"
    )
    breaks = group_breaks([(each.indicator, each.quantity) for each in rows])
    table = Table(columns, "Estimates against the truth", "estimates", (note,), breaks)
    return Block("estimates", "Estimates", (_ORDER,), (table,))


def _share_text(rate: Rate | None) -> str:
    if rate is None:
        return HOLE
    return f"{100.0 * rate.value:.0f} ({100.0 * rate.low:.0f}–{100.0 * rate.high:.0f})"


def _left_out(estimates: Estimates) -> str:
    """Sentences on what the table does not list, and why."""
    sentences = ""
    if not estimates.has_constant_leaks:
        sentences += " Faults are left out: leaks set in during the record, so there is no single true value."
    if estimates.without_deviation:
        sentences += f" Not listed because they state no deviation: {joined(estimates.without_deviation)}."
    return sentences


def estimate_records(judged: Sequence[Estimates]) -> list[dict[str, Any]]:
    """Plain data for JSON, one record for each estimate and population."""
    return [_record(each) for estimates in judged for each in estimates.judgements]


def _record(each: EstimateJudgement) -> dict[str, Any]:
    unit = "percent" if each.quantity == "bulk_modulus" else "L_per_min"
    numbers = {"mean_error": each.bias, "deviation": each.deviation, "stated_deviation": each.stated}
    return {
        "indicator": each.indicator,
        "quantity": "bulk_modulus" if each.quantity == "bulk_modulus" else "leakage",
        "population": each.population,
        "n": each.n,
        "not_measurable": each.not_measurable,
        **{f"{name}_{unit}": finite(_shown(each.quantity, value)) for name, value in numbers.items()},
        "covered": finite(each.covered.value),
        "covered_low": each.covered.low,
        "covered_high": each.covered.high,
    }


def _shown(quantity: str, value: float) -> float:
    """L/min at the reference pressure, or percent."""
    if quantity == "bulk_modulus":
        return 100.0 * value
    return convert(value * math.sqrt(REFERENCE_PRESSURE), "L/min")
