"""The section on estimates: their errors, and whether their intervals cover the truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.report.document import Block, Cell, Sheet, group_breaks
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.wording import joined
from hydrofdi.settings.readable import HOLE, two_digits
from hydrofdi.studies.estimates.judging import EstimateJudgement, Estimates
from hydrofdi.units import convert

REFERENCE_PRESSURE = 8e6
"""Pressure difference at which K_i is shown as a flow [Pa]."""

_NAMES = {"internal_coefficient": "leakage [L/min]", "bulk_modulus": "β [% of the truth]"}
_ORDER = (
    "The truth is known only for simulated records, and no indicator sees it. Error: estimate minus truth."
)


def estimates_block(estimates: Estimates) -> Block | None:
    """How far estimates are from the truth; None if nothing is estimated."""
    if not estimates.judgements:
        return None
    level = f"{100.0 * estimates.confidence:g} %"
    headers = (
        "Indicator",
        "Estimate",
        "Population",
        "Mean error",
        "1σ of errors",
        "1σ stated",
        "Covered [%]",
    )
    note = (
        f"Leakage: the flow of K_i at {REFERENCE_PRESSURE / 1e6:g} MPa. 1σ stated: root mean square. Covered:"
        f" records whose stated {level} interval contains the truth, with the {level} interval of that share."
        f"{_left_out(estimates)}"
    )
    sheet = Sheet(
        "estimates",
        "Estimates against the truth",
        headers,
        tuple(_row(each) for each in estimates.judgements),
        group_breaks([(each.indicator, each.quantity) for each in estimates.judgements]),
        (0, 1, 2),
        note,
    )
    return Block("estimates", "Estimates", (_ORDER,), (sheet,))


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


def _row(each: EstimateJudgement) -> tuple[Cell, ...]:
    numbers = (_shown(each.quantity, value) for value in (each.bias, each.deviation, each.stated))
    rate = each.covered
    covered = f"{_percent(rate.value)} ({_percent(rate.low)}–{_percent(rate.high)})" if each.n else HOLE
    return (
        Cell(each.indicator),
        Cell(_NAMES[each.quantity]),
        Cell(each.population),
        *(Cell(HOLE if math.isnan(value) else two_digits(value), value=finite(value)) for value in numbers),
        Cell(covered, value=finite(100.0 * rate.value)),
    )


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


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f}"
