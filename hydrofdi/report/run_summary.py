"""The features of one run, for people and for programs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hydrofdi.config import RunSpec
from hydrofdi.config.shown_values import shown_value
from hydrofdi.report.forms.numbers import finite
from hydrofdi.report.table import Column, Table
from hydrofdi.store import Columns
from hydrofdi.store.layout import names
from hydrofdi.units import convert


@dataclass(frozen=True)
class RunSummary:
    """Features of one run in SI.

    Attributes
    ----------
    run : RunSpec
    run_id, status, message : str
    mean_leakage_flow, leakage_coefficient : float
        Mean of abs(q_il) [m³/s] and K_i [m^3.5/kg^0.5].
    detail_rms, approximation_rms : tuple of float
        RMS of d1, d2, … and of a1, a2, … of P_1 [Pa].
    external_flows : tuple of float
        Mean external leakage out of chamber 1 and chamber 2 [m³/s].
    extremes, residuals : dict
        Name as in the experiment file → value.
    verdict : str
        Reliability of the run.
    mode_frequency, mode_damping_ratio : float
        f_h [Hz] and ζ [-].
    """

    run: RunSpec
    run_id: str
    status: str
    message: str
    mean_leakage_flow: float
    leakage_coefficient: float
    detail_rms: tuple[float, ...]
    approximation_rms: tuple[float, ...]
    external_flows: tuple[float, ...]
    extremes: dict[str, float]
    verdict: str
    residuals: dict[str, float]
    mode_frequency: float
    mode_damping_ratio: float

    @property
    def title(self) -> str:
        """The run in a few words."""
        leakage = (
            f"{convert(self.mean_leakage_flow, 'L/min'):.3g} L/min" if self.leakage_coefficient else "sealed"
        )
        return f"EBM {shown_value('fluid.bulk_modulus', self.run.parameters.fluid.bulk_modulus)}, {leakage}"

    @property
    def table(self) -> Table:
        """Name, value and unit of each feature, for people."""
        names, values, units = zip(*self._lines(), strict=True)
        return Table(
            (
                Column("feature", names, is_text=True),
                Column("value", values),
                Column("unit", units, is_text=True),
            ),
            title=self.title,
        )

    def _lines(self) -> Iterator[tuple[str, str, str]]:
        yield "run", self.run_id, ""
        yield "status", self.status, ""
        yield "verdict", self.verdict, ""
        yield "leakage coefficient K_i", f"{self.leakage_coefficient:.4g}", "m³/s per √Pa"
        yield "mean internal leakage", f"{convert(self.mean_leakage_flow, 'L/min'):.4g}", "L/min"
        for chamber, flow in enumerate(self.external_flows, 1):
            if flow:
                yield f"mean leakage out of chamber {chamber}", f"{convert(flow, 'L/min'):.4g}", "L/min"
        for level, rms in enumerate(self.detail_rms, 1):
            yield f"RMS of d{level}", f"{convert(rms, 'kPa'):.3f}", "kPa"
        for title, name, unit in (
            ("chamber-1 pressure", "chamber_1_pressure", "MPa"),
            ("chamber-2 pressure", "chamber_2_pressure", "MPa"),
            ("piston position", "piston_position", "mm"),
        ):
            low, high = (convert(self.extremes[f"{name}_{end}"], unit) for end in ("min", "max"))
            yield title, f"{low:.3f} … {high:.3f}", unit
        yield "hydraulic mode f_h", f"{self.mode_frequency:.2f}", "Hz"
        yield "damping ratio ζ", f"{self.mode_damping_ratio:.4f}", "(linearised, median working point)"
        for name, value in self.residuals.items():
            yield name.replace("_", " "), "–" if math.isnan(value) else f"{value:.1e}", ""


def summarize_run(run: RunSpec, columns: Columns) -> RunSummary:
    """The summary of the single run in `columns`."""
    return RunSummary(
        run=run,
        run_id=str(columns[names.RUN_ID][0]),
        status=str(columns[names.STATUS][0]),
        message=str(columns[names.MESSAGE][0]),
        mean_leakage_flow=float(columns[names.MEAN_LEAKAGE_FLOW][0]),
        leakage_coefficient=float(columns[names.LEAKAGE_COEFFICIENT][0]),
        detail_rms=tuple(columns[names.DETAIL_RMS][0].tolist()),
        approximation_rms=tuple(columns[names.APPROXIMATION_RMS][0].tolist()),
        external_flows=tuple(float(columns[name][0]) for name in names.EXTERNAL_LEAKAGE_FLOWS),
        extremes={variable.name: float(columns[variable.name][0]) for variable in names.EXTREMES},
        verdict=str(columns[names.VERDICT][0]),
        residuals={
            name: float(columns[name][0])
            for name in ("settling_change", "volume_residual", "energy_residual")
        },
        mode_frequency=float(columns[names.MODE_FREQUENCY][0]),
        mode_damping_ratio=float(columns[names.MODE_DAMPING_RATIO][0]),
    )


def run_record(summary: RunSummary) -> dict[str, Any]:
    """The summary as plain data for JSON; numbers that do not exist are None."""
    mean = summary.mean_leakage_flow
    return {
        "run_id": summary.run_id,
        "status": summary.status,
        "message": summary.message,
        "parameters": summary.run.request.shown_sections(),
        "mean_internal_leakage_L_per_min": None if math.isnan(mean) else convert(mean, "L/min"),
        "internal_leakage_coefficient": summary.leakage_coefficient,
        "detail_rms_Pa": [finite(value) for value in summary.detail_rms],
        "approximation_rms_Pa": [finite(value) for value in summary.approximation_rms],
        "mean_external_leakage_L_per_min": [finite(convert(q, "L/min")) for q in summary.external_flows],
        "verdict": summary.verdict,
        "residuals": {name: finite(value) for name, value in summary.residuals.items()},
        "extremes": {name: finite(value) for name, value in summary.extremes.items()},
        "hydraulic_mode_Hz": finite(summary.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(summary.mode_damping_ratio),
    }
