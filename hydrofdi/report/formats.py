"""The table as Markdown, CSV, LaTeX and JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Sequence
from typing import Any

from hydrofdi.report.table import SensitivityTable, TableRow, label_header, largest_positive
from hydrofdi.units import convert

BASELINES: dict[str, Callable[[TableRow], tuple[float, ...]]] = {
    "fixed": lambda row: row.delta_fixed,
    "matched": lambda row: row.delta_matched,
}
"""Kind of baseline → δ of a row against it."""


def baseline_title(table: SensitivityTable, baseline: str) -> str:
    """What δ is taken against, as a title."""
    if baseline == "fixed":
        return (
            f"δ [%] against the fixed normal (sealed, EBM {convert(table.normal_bulk_modulus, 'MPa'):g} MPa)"
        )
    return "δ [%] against the matched baseline (sealed, the row's own EBM)"


def band_note(table: SensitivityTable) -> str:
    """Bands of the levels, and where the hydraulic mode lies for each EBM."""
    bands = ", ".join(f"d{level} {low:g}–{high:g}" for level, (low, high) in enumerate(table.bands, 1))
    modes = ", ".join(
        f"{frequency:.1f} ({_level_at(table, frequency)}) at {convert(beta, 'MPa'):g} MPa"
        for beta, frequency in table.modes.items()
    )
    return f"Bands [Hz]: {bands}. Hydraulic mode f_h [Hz]: {modes}."


def _level_at(table: SensitivityTable, frequency: float) -> str:
    for level, (low, high) in enumerate(table.bands, 1):
        if low <= frequency < high:
            return f"d{level}"
    return "above d1" if frequency >= table.bands[0][1] else f"below d{table.n_level}"


def leakage_label(row: TableRow) -> str:
    """The leakage level of a row in L/min."""
    return "sealed" if row.is_sealed else _number(convert(row.leakage_flow, "L/min"), ".3g")


def _number(value: float, form: str) -> str:
    """A number in a form; a dash where it does not exist."""
    return "–" if math.isnan(value) else format(value, form)


def lead_headers(table: SensitivityTable) -> list[str]:
    """Headers of the columns that say which run a row is."""
    labels = [label_header(name) for name in table.label_names]
    return ["Leakage [L/min]", "EBM [MPa]", *labels, "f_h [Hz]"]


def lead_cells(row: TableRow) -> list[str]:
    """Cells under `lead_headers`."""
    labels = [f"{value:g}" if isinstance(value, float) else str(value) for value in row.labels.values()]
    return [
        leakage_label(row),
        f"{convert(row.bulk_modulus, 'MPa'):g}",
        *labels,
        _number(row.mode_frequency, ".1f"),
    ]


def delta_cells(levels: Sequence[float], emphasize: Callable[[str], str]) -> list[str]:
    """δ of each level with one decimal, the largest positive one emphasized."""
    best = largest_positive(levels)
    cells = ["–" if math.isnan(value) else f"{value + 0.0:+.1f}" for value in levels]
    cells = ["0.0" if cell in {"+0.0", "-0.0"} else cell for cell in cells]
    return [emphasize(cell) if level == best else cell for level, cell in enumerate(cells)]


def failure_notes(table: SensitivityTable) -> list[str]:
    """A sentence on each row that failed."""
    return [
        f"{leakage_label(row)} at {convert(row.bulk_modulus, 'MPa'):g} MPa: {row.status}: {row.message}"
        for row in table.rows
        if row.status != "ok"
    ]


def render_markdown(table: SensitivityTable) -> str:
    """The table in Markdown, once per baseline."""
    parts = [f"# {table.name}: change of the detail RMS of the chamber-1 pressure", band_note(table)]
    headers = [*lead_headers(table), *(f"δd{level}" for level in range(1, table.n_level + 1))]
    for baseline, delta in BASELINES.items():
        lines = [_pipe(headers), _pipe(["---:"] * len(headers))]
        for row in table.rows:
            lines.append(_pipe([*lead_cells(row), *delta_cells(delta(row), "**{}**".format)]))
        parts += [f"## {baseline_title(table, baseline)}", "\n".join(lines)]
    parts.append("Bold: largest positive δ of the row. δ > 0: the RMS fell. Rows marked sealed are controls.")
    parts += [f"Failed: {note}" for note in failure_notes(table)]
    return "\n\n".join(parts) + "\n"


def _pipe(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def render_csv(table: SensitivityTable) -> str:
    """The table as tidy CSV: one line per run and level, units in the header."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        [
            "leakage_L_per_min", "bulk_modulus_MPa", *(label_header(name) for name in table.label_names),
            "internal_leakage_coefficient_m3.5_per_kg0.5", "mean_internal_leakage_L_per_min",
            "hydraulic_mode_Hz", "level", "detail_rms_Pa", "delta_fixed_percent", "delta_matched_percent",
            "largest_positive_fixed", "largest_positive_matched", "status",
        ]
    )  # fmt: skip
    for row in table.rows:
        best = largest_positive(row.delta_fixed), largest_positive(row.delta_matched)
        for level in range(table.n_level):
            writer.writerow(
                [
                    convert(row.leakage_flow, "L/min"), convert(row.bulk_modulus, "MPa"),
                    *row.labels.values(),
                    row.leakage_coefficient, convert(row.mean_leakage_flow, "L/min"), row.mode_frequency,
                    f"d{level + 1}", row.detail_rms[level], row.delta_fixed[level], row.delta_matched[level],
                    int(best[0] == level), int(best[1] == level), row.status,
                ]
            )  # fmt: skip
    return text.getvalue()


def render_latex(table: SensitivityTable) -> str:
    """The table for LaTeX with the package booktabs, once per baseline."""
    n_lead = len(lead_headers(table))
    lines = [f"% hydrofdi: {_latex(table.name)}; needs the package booktabs"]
    for baseline, delta in BASELINES.items():
        headers = [
            *map(_latex, lead_headers(table)),
            *(f"$\\delta d_{k}$" for k in range(1, table.n_level + 1)),
        ]
        lines += [
            f"% {_latex(baseline_title(table, baseline))}",
            rf"\begin{{tabular}}{{{'r' * (n_lead + table.n_level)}}}",
            r"\toprule",
            " & ".join(headers) + r" \\",
            r"\midrule",
        ]
        for row in table.rows:
            deltas = [_latex(cell) for cell in delta_cells(delta(row), "<{}>".format)]
            cells = [*map(_latex, lead_cells(row)), *deltas]
            lines.append(" & ".join(cells) + r" \\")
        lines += [r"\bottomrule", r"\end{tabular}", ""]
    return "\n".join(lines)


_LATEX = {
    "%": r"\%", "_": r"\_", "&": r"\&", "#": r"\#", "δ": r"$\delta$", "·": r"$\cdot$", "–": "--",
    "^": r"\^{}", "+": "$+$", "-": "$-$", "<": r"\textbf{", ">": "}",
}  # fmt: skip


def _latex(text: str) -> str:
    return "".join(_LATEX.get(character, character) for character in text)


def table_record(table: SensitivityTable) -> dict[str, Any]:
    """The table as plain data for JSON; numbers that do not exist are None."""
    return {"experiment": table.name, "rows": [_row_record(row) for row in table.rows]}


def render_json(table: SensitivityTable) -> str:
    """The table as JSON."""
    return json.dumps(table_record(table), indent=2, allow_nan=False) + "\n"


def _row_record(row: TableRow) -> dict[str, Any]:
    return {
        "leakage_L_per_min": finite(convert(row.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        "internal_leakage_coefficient": row.leakage_coefficient,
        "mean_internal_leakage_L_per_min": finite(convert(row.mean_leakage_flow, "L/min")),
        "hydraulic_mode_Hz": finite(row.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(row.mode_damping_ratio),
        "detail_rms_Pa": [finite(value) for value in row.detail_rms],
        "delta_fixed_percent": [finite(value) for value in row.delta_fixed],
        "delta_matched_percent": [finite(value) for value in row.delta_matched],
        "largest_positive_fixed": _level_name(largest_positive(row.delta_fixed)),
        "largest_positive_matched": _level_name(largest_positive(row.delta_matched)),
        "labels": row.labels,
        "sealed": row.is_sealed,
        "status": row.status,
        "message": row.message,
    }


def _level_name(level: int | None) -> str | None:
    return None if level is None else f"d{level + 1}"


def finite(value: float) -> float | None:
    """The value, or None where it is NaN or infinite."""
    return value if math.isfinite(value) else None
