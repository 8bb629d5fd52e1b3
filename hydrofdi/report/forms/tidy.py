"""The runs as tidy columns: one line per run and level, units in the header; as CSV and as Parquet."""

from __future__ import annotations

import csv
import io
from typing import Any

from hydrofdi.errors import ReportError
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.table import SensitivityTable, TableRow, label_header, largest_positive
from hydrofdi.units import convert


def tidy_columns(table: SensitivityTable) -> dict[str, list[Any]]:
    """Header → values, one per run and level; None where a number is missing."""
    records = [
        _row_record(row) | _level_record(row, level) | {"status": row.status, "verdict": row.verdict}
        for row in table.rows
        for level in range(table.n_level)
    ]
    return {header: [record[header] for record in records] for header in records[0]}


def _row_record(row: TableRow) -> dict[str, Any]:
    return {
        "run_id": row.run_id,
        "leakage_L_per_min": finite(convert(row.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        **{label_header(name): value for name, value in row.labels.items()},
        "internal_leakage_coefficient_m3.5_per_kg0.5": finite(row.leakage_coefficient),
        "mean_internal_leakage_L_per_min": finite(convert(row.mean_leakage_flow, "L/min")),
        "mean_external_leakage_1_L_per_min": finite(convert(row.external.flows[0], "L/min")),
        "mean_external_leakage_2_L_per_min": finite(convert(row.external.flows[1], "L/min")),
        "mean_chamber_1_pressure_Pa": finite(row.mean_pressure),
        "hydraulic_mode_Hz": finite(row.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(row.mode_damping_ratio),
    }


def _level_record(row: TableRow, level: int) -> dict[str, Any]:
    return {
        "level": f"d{level + 1}",
        "detail_rms_Pa": finite(row.detail_rms[level]),
        "delta_fixed_percent": finite(row.delta_fixed[level]),
        "delta_matched_percent": finite(row.delta_matched[level]),
        "largest_positive_fixed": int(largest_positive(row.delta_fixed) == level),
        "largest_positive_matched": int(largest_positive(row.delta_matched) == level),
        "approximation_rms_Pa": finite(row.approximations.rms[level]),
        "approximation_delta_fixed_percent": finite(row.approximations.fixed[level]),
        "approximation_delta_matched_percent": finite(row.approximations.matched[level]),
    }


def render_csv(table: SensitivityTable) -> str:
    """The runs as CSV; numbers in their shortest exact form, an empty field where one is missing."""
    columns = tidy_columns(table)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue()


def render_parquet(table: SensitivityTable) -> bytes:
    """The runs as Parquet.

    Raises
    ------
    ReportError
        The extra is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise ReportError("Parquet needs the extra: pip install 'hydrofdi[parquet]'") from None
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(tidy_columns(table)), sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content
