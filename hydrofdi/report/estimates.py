"""The section on estimates: their errors, and whether their intervals cover the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.report.table import Block, Table, finite, group_breaks
from hydrofdi.report.wording import joined
from hydrofdi.studies.truth import EstimateJudgement, Estimates
from hydrofdi.units import convert

REFERENCE_PRESSURE = 8e6
"""Pressure difference at which K_i is shown as a flow [Pa]."""

_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(estimates: Estimates) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    rows = estimate_records([estimates])
    if not rows:
        return None
    level = f"{100.0 * estimates.confidence:g} %"
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_PRESSURE / 1e6:g} MPa. Deviations: 1σ of the errors, and as"
        f" stated (root mean square). Covered: share of the records whose stated {level} interval contains"
        f" the truth, with its {level} interval.{_left_out(estimates)}"
    )
    breaks = group_breaks([(each["indicator"], each["quantity"]) for each in rows])
    title = "Estimates against the truth"
    table = Table.of_records(rows, title=title, key="estimates", notes=(note,), breaks=breaks)
    return Block("estimates", "Estimates", (_ORDER,), (table,))


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
