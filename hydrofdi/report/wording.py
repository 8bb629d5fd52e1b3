"""Numbers as text in a report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hydrofdi.config.shown_values import ShownParameter, shown_parameter, shown_values
from hydrofdi.report.document import Cell
from hydrofdi.report.intervals import Share
from hydrofdi.report.runs.rows import TableRow, largest_positive
from hydrofdi.report.runs.table import EXTERNAL, SensitivityTable
from hydrofdi.units import convert

HOLE = "–"
"""Shown in place of a missing number."""

_MOST_WORDS = 12
"""Most cases that a sentence names one by one."""

_MOST_MODES = 12
"""Most EBM for which a sentence names each hydraulic mode."""


def shown_modulus() -> ShownParameter:
    """how people read the EBM: in MPa where the experiment is not written in another unit."""
    return shown_parameter("fluid.bulk_modulus", [1e9])


def modulus_text(bulk_modulus: float) -> str:
    """An EBM with its unit."""
    return f"{shown_modulus().text(bulk_modulus)} {shown_modulus().unit}"


def modulus_header() -> str:
    """Header of a column of EBM."""
    return f"EBM [{shown_modulus().unit}]"


def modulus_cell(bulk_modulus: float) -> Cell:
    """An EBM under `modulus_header`."""
    return Cell(shown_modulus().text(bulk_modulus), value=shown_modulus().number(bulk_modulus))


def litres_per_minute(flow: float) -> str:
    """A leakage flow in L/min, without the unit."""
    return f"{convert(flow, 'L/min'):.3g}"


def flow_text(flow: float) -> str:
    """A flow in L/min without the unit, or a hole."""
    return HOLE if math.isnan(flow) else litres_per_minute(flow)


def mode_name(leakage_flow: float, bulk_modulus: float) -> str:
    """A mode in words, e.g. ``0.12 L/min at 551 MPa``."""
    leakage = f"{litres_per_minute(leakage_flow)} L/min" if leakage_flow else "sealed"
    return f"{leakage} at {modulus_text(bulk_modulus)}"


def labels_text(labels: dict[str, Any]) -> str:
    """Values of further parameters, e.g. ``friction.viscous = 50 N·s/m``."""
    return shown_values(labels)


def other_conditions(row: TableRow) -> str:
    """External leakage and further parameters of a row, e.g. ``0.6 L/min out of chamber 1``."""
    labels = {name: value for name, value in row.labels.items() if not name.startswith(EXTERNAL)}
    flows = [
        f"{flow_text(flow)} L/min out of chamber {chamber}"
        for chamber, flow in enumerate(row.external.flows, 1)
        if row.external.coefficients[chamber - 1]
    ]
    return ", ".join(filter(None, [*flows, labels_text(labels)]))


def row_name(row: TableRow) -> str:
    """A row in words, e.g. ``sealed at 827 MPa, 0.6 L/min out of chamber 1``."""
    mode = mode_name(row.leakage_flow, row.bulk_modulus)
    if math.isnan(row.leakage_flow):
        mode = f"{leakage_label(row)} at {mode.partition(' at ')[2]}"
    return ", ".join(filter(None, [mode, other_conditions(row)]))


def plain(value: Any) -> str:
    """A parameter value in SI."""
    return f"{value:g}" if isinstance(value, float) else str(value)


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
    return HOLE if math.isnan(pressure) else f"{convert(pressure, 'kPa'):.2f}"


def delta_cells(levels: Sequence[float]) -> list[Cell]:
    """δ of each level, the largest positive one strong unless it rounds to zero."""
    best = largest_positive(levels)
    texts = map(signed, levels)
    return [Cell(text, level == best and text != "0.0", levels[level]) for level, text in enumerate(texts)]


EXTERNAL_HEADERS = ("Out of 1 [L/min]", "Out of 2 [L/min]")
"""Headers of the mean flows of the external leakage."""


def external_cells(row: TableRow) -> list[Cell]:
    """Cells under `EXTERNAL_HEADERS`."""
    pairs = zip(row.external.flows, row.external.coefficients, strict=True)
    return [Cell(flow_text(q) if k else "0", value=convert(q, "L/min")) for q, k in pairs]


def lead_headers(table: SensitivityTable) -> list[str]:
    """Headers of the columns that say which run a row is."""
    external = EXTERNAL_HEADERS if table.varies_external else ()
    labels = [shown.header for name, shown in table.shown_labels.items() if not name.startswith(EXTERNAL)]
    return ["Leakage [L/min]", modulus_header(), *external, *labels, "f_h [Hz]"]


def lead_cells(table: SensitivityTable, row: TableRow) -> list[Cell]:
    """Cells under `lead_headers`; external leakage as the flow that it causes."""
    plain_labels = {name: value for name, value in row.labels.items() if not name.startswith(EXTERNAL)}
    labels = external_cells(row) if len(plain_labels) < len(row.labels) else []
    labels += [Cell(table.shown_labels[name].text(value)) for name, value in plain_labels.items()]
    frequency = HOLE if math.isnan(row.mode_frequency) else f"{row.mode_frequency:.1f}"
    return [
        Cell(leakage_label(row), value=convert(row.leakage_flow, "L/min")),
        modulus_cell(row.bulk_modulus),
        *labels,
        Cell(frequency, value=row.mode_frequency),
    ]


def leakage_label(row: TableRow) -> str:
    """The leakage level of a row in L/min; its K_i if only that is known, as for a missing run."""
    if row.is_sealed:
        return "sealed"
    flow = row.leakage_flow
    return f"K_i {plain(row.leakage_request)}" if math.isnan(flow) else flow_text(flow)


def band_sentence(table: SensitivityTable) -> str:
    """Bands of the levels, and where the hydraulic mode lies for each EBM; for many, the ends."""
    bands = ", ".join(f"d{level} {low:g}–{high:g}" for level, (low, high) in enumerate(table.bands, 1))
    texts = [f"{_frequencies(table, *ends)} at {modulus_text(beta)}" for beta, ends in table.modes.items()]
    modes = ", ".join(texts) if len(texts) <= _MOST_MODES else f"{texts[0]} to {texts[-1]}"
    return f"Bands [Hz]: {bands}. Hydraulic mode f_h [Hz]: {modes or HOLE}."


def _frequencies(table: SensitivityTable, least: float, largest: float) -> str:
    """``59.6 (d3)``, or a range."""
    ends = dict.fromkeys((f"{least:.1f}", f"{largest:.1f}"))
    levels = dict.fromkeys((_level_at(table, least), _level_at(table, largest)))
    return f"{'–'.join(ends)} ({'–'.join(levels)})"


def _level_at(table: SensitivityTable, frequency: float) -> str:
    for level, (low, high) in enumerate(table.bands, 1):
        if low <= frequency < high:
            return f"d{level}"
    return "above d1" if frequency >= table.bands[0][1] else f"below d{table.n_level}"


def capitalized(sentence: str) -> str:
    """A sentence that starts with a capital, unless it starts with the name of a score such as dwt.d1."""
    first = sentence.partition(" ")[0].rstrip(".,;:")
    is_name = "_" in first or "." in first
    return sentence if is_name else f"{sentence[:1].upper()}{sentence[1:]}"


def joined(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 2 else words)


def some(words: Sequence[str]) -> str:
    """``a, b and c``; of many the first, and how many more there are."""
    rest = len(words) - _MOST_WORDS
    return joined(words) if rest <= 0 else joined([*words[:_MOST_WORDS], f"{rest:,} more"])


def share_text(share: Share, *, with_interval: bool) -> str:
    """A share in percent, e.g. ``3.5 % (2.7–4.5)``; a hole if there is nothing to share."""
    if not share.total:
        return HOLE
    interval = f" ({100.0 * share.low:.1f}–{100.0 * share.high:.1f})" if with_interval else ""
    return f"{100.0 * share.value:.1f} %{interval}"
