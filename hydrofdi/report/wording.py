"""Numbers, conditions and rows as text in a report, and the columns that say what a row is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hydrofdi.config.shown_values import ShownParameter, shown_parameter
from hydrofdi.report.runs import EXTERNAL, Array, RunTable, best_levels
from hydrofdi.settings.messages import HOLE
from hydrofdi.store.layout import names
from hydrofdi.tables.table import Column
from hydrofdi.units import convert


def shown_modulus() -> ShownParameter:
    """How people read the EBM: in MPa where the experiment is not written in another unit."""
    return shown_parameter("fluid.bulk_modulus", [1e9])


def modulus_text(bulk_modulus: float) -> str:
    """An EBM with its unit."""
    return f"{shown_modulus().text(bulk_modulus)} {shown_modulus().unit}"


def modulus_column(bulk_moduli: Sequence[float] | Array) -> Column:
    """A column of EBM."""
    shown = shown_modulus()
    return Column("bulk_modulus", bulk_moduli, "Pa", f"EBM [{shown.unit}]", shown.text)


def litres_per_minute(flow: float) -> str:
    """A leakage flow in L/min, without the unit, or a hole."""
    return hole_or(flow, f"{convert(flow, 'L/min'):.3g}")


def mode_name(leakage_flow: float, bulk_modulus: float) -> str:
    """A mode in words, e.g. ``0.12 L/min at 551 MPa``."""
    leakage = f"{litres_per_minute(leakage_flow)} L/min" if leakage_flow else "sealed"
    return f"{leakage} at {modulus_text(bulk_modulus)}"


def lead_columns(table: RunTable) -> list[Column]:
    """What says which run a row is; external leakage as the flow that it causes."""
    pairs = zip(table.leakage_requests.tolist(), table.leakage_flows.tolist(), strict=True)
    # of a missing run only K_i is known
    leakages = [
        "sealed" if not request else f"K_i {request:g}" if math.isnan(flow) else litres_per_minute(flow)
        for request, flow in pairs
    ]
    columns = [Column("Leakage [L/min]", leakages), modulus_column(table[names.BULK_MODULUS])]
    if table.varies_external:
        chambers = zip(table.external_flows.T, table.external_coefficients.T, strict=True)
        for chamber, (flows, k) in enumerate(chambers, 1):
            texts = [litres_per_minute(flow) if k[row] else "0" for row, flow in enumerate(flows.tolist())]
            columns.append(Column(f"Out of {chamber} [L/min]", texts))
    for name in table.label_names:
        if not name.startswith(EXTERNAL):
            shown = shown_parameter(name, values := table.values(name))
            columns.append(Column(shown.header, values, text=shown.text))
    return columns


def delta_columns(delta: Array) -> list[Column]:
    """δ of each level; the largest positive one of a row stands out, unless it rounds to zero."""
    best = best_levels(delta)
    return [
        Column(
            f"δd{level + 1}",
            own,
            text=signed,
            strong=[k for k in np.flatnonzero(best == level).tolist() if signed(own[k]) != "0.0"],
        )
        for level, own in enumerate(delta.T)
    ]


def band_sentence(table: RunTable) -> str:
    """Bands of the levels."""
    bands = ", ".join(f"d{level} {low:g}–{high:g}" for level, (low, high) in enumerate(table.bands, 1))
    return f"Bands [Hz]: {bands}."


def hole_or(value: float, text: str) -> str:
    """A text, or a hole if its number is missing."""
    return HOLE if math.isnan(value) else text


def signed(value: float, decimals: int = 1) -> str:
    """A number with its sign; no sign where it rounds to zero; a hole if it is missing."""
    if math.isnan(value):
        return HOLE
    text = f"{value:+.{decimals}f}"
    return with_minus(text[1:] if float(text) == 0.0 else text)


def with_minus(number: str) -> str:
    """A number as people print it, with the minus sign of the field and not a hyphen."""
    return number.replace("-", "\N{MINUS SIGN}")


def kilopascal(pressure: float) -> str:
    """A pressure in kPa with two decimals, or a hole."""
    return hole_or(pressure, f"{convert(pressure, 'kPa'):.2f}")


def span_text(low: str, high: str) -> str:
    """A range that is not broken; one number where both ends print alike."""
    return low if low == high else f"{low} … {high}".replace(" ", "\N{NO-BREAK SPACE}")


def capitalized(sentence: str) -> str:
    """A sentence that starts with a capital, unless it starts with the name of a score such as dwt.d1."""
    first = sentence.partition(" ")[0].rstrip(".,;:")
    is_name = "_" in first or "." in first
    return sentence if is_name else f"{sentence[:1].upper()}{sentence[1:]}"


def joined(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 2 else words)
