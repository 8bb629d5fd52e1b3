"""Tidy columns with units in the header, as CSV and as Parquet; of runs, one line per run and level."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from hydrofdi.config.request import parameter_unit
from hydrofdi.errors import ReportError
from hydrofdi.report.analysis import Analysis
from hydrofdi.report.forms.indicators_record import output_columns
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.forms.separated import csv_lines
from hydrofdi.report.runs.rows import TableRow, largest_positive
from hydrofdi.units import convert


def tidy_columns(analysis: Analysis) -> dict[str, list[Any]]:
    """Header → values, one per run and level; None if a number is missing."""
    table, n_level = analysis.table, analysis.table.n_level
    leads, ends = [_row_record(row) for row in table.rows], [_end_record(row) for row in table.rows]
    levels = [record for row in table.rows for record in _level_records(row)]
    return {
        **_repeated(leads, n_level),
        **{header: [record[header] for record in levels] for header in levels[0]},
        **_repeated([_measured_record(analysis, row) for row in table.rows], n_level),
        **_repeated(ends, n_level),
    }


def _repeated(records: list[dict[str, Any]], count: int) -> dict[str, list[Any]]:
    return {header: [r[header] for r in records for _ in range(count)] for header in records[0]}


def _row_record(row: TableRow) -> dict[str, Any]:
    return {
        "run_id": row.run_id,
        "leakage_L_per_min": finite(convert(row.leakage_flow, "L/min")),
        "bulk_modulus_MPa": convert(row.bulk_modulus, "MPa"),
        **{_si_header(name): value for name, value in row.labels.items()},
        "internal_leakage_coefficient_m3.5_per_kg0.5": finite(row.leakage_coefficient),
        "mean_internal_leakage_L_per_min": finite(convert(row.mean_leakage_flow, "L/min")),
        "mean_external_leakage_1_L_per_min": finite(convert(row.external.flows[0], "L/min")),
        "mean_external_leakage_2_L_per_min": finite(convert(row.external.flows[1], "L/min")),
        "mean_chamber_1_pressure_Pa": finite(row.mean_pressure),
        "hydraulic_mode_Hz": finite(row.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(row.mode_damping_ratio),
    }


def _si_header(name: str) -> str:
    """A varied parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name


def _measured_record(analysis: Analysis, row: TableRow) -> dict[str, Any]:
    """Values that the indicators measured for a run, and their changes."""
    record: dict[str, Any] = {}
    for study in analysis.indicators:
        record |= output_columns(study, row.position)
    return record


def _end_record(row: TableRow) -> dict[str, Any]:
    return {"status": row.status, "verdict": row.verdict}


def _level_records(row: TableRow) -> Iterator[dict[str, Any]]:
    best_fixed, best_matched = largest_positive(row.delta_fixed), largest_positive(row.delta_matched)
    for level, rms in enumerate(row.detail_rms):
        yield {
            "level": f"d{level + 1}",
            "detail_rms_Pa": finite(rms),
            "delta_fixed_percent": finite(row.delta_fixed[level]),
            "delta_matched_percent": finite(row.delta_matched[level]),
            "largest_positive_fixed": int(best_fixed == level),
            "largest_positive_matched": int(best_matched == level),
            "approximation_rms_Pa": finite(row.approximations.rms[level]),
            "approximation_delta_fixed_percent": finite(row.approximations.fixed[level]),
            "approximation_delta_matched_percent": finite(row.approximations.matched[level]),
            "settled_detail_rms_Pa": finite(row.settled_details.rms[level]),
            "settled_delta_fixed_percent": finite(row.settled_details.fixed[level]),
            "settled_delta_matched_percent": finite(row.settled_details.matched[level]),
            "settled_approximation_delta_fixed_percent": finite(row.settled_approximations.fixed[level]),
            "settled_approximation_delta_matched_percent": finite(row.settled_approximations.matched[level]),
        }


def render_csv(columns: Mapping[str, Sequence[Any]]) -> str:
    """Columns as CSV; numbers in their shortest exact form, an empty field if a number is missing."""
    return "".join(csv_lines([columns, *zip(*columns.values(), strict=True)]))


def render_parquet(columns: Mapping[str, Sequence[Any]]) -> bytes:
    """Columns as Parquet.

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
    parquet.write_table(pyarrow.table(dict(columns)), sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content
