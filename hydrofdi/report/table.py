"""The runs of an experiment as rows: RMS of the details, and their change against both baselines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.config.parameters import parameter_unit
from hydrofdi.features import level_bands, percentage_change
from hydrofdi.store import ExperimentData, names

Levels = tuple[float, ...]
"""One number per wavelet level, d1 first; NaN where a run failed."""


@dataclass(frozen=True)
class TableRow:
    """One run of the table, in SI and percent.

    Attributes
    ----------
    run_id : str
        Identity of the run.
    labels : dict
        Further varied parameters → their values in SI.
    leakage_request : float
        Mean flow [m³/s] or K_i [m^3.5/kg^0.5] that was asked for; 0 for a sealed actuator.
    leakage_flow : float
        Leakage level of the row [m³/s]: the mean flow that K_i was solved for, or the flow of the run.
    mean_leakage_flow : float
        Mean of abs(q_il) in the run itself [m³/s].
    leakage_coefficient, bulk_modulus : float
        K_i [m^3.5/kg^0.5] and β [Pa].
    mode_frequency, mode_damping_ratio : float
        f_h [Hz] and ζ [-].
    detail_rms : tuple of float
        RMS of d1, d2, … [Pa].
    delta_fixed, delta_matched : tuple of float
        δ [%] against the baseline's conditions, and against the sealed actuator in the run's own conditions.
    status, message : str
        How the run ended.
    """

    run_id: str
    labels: dict[str, Any]
    leakage_request: float
    leakage_flow: float
    mean_leakage_flow: float
    leakage_coefficient: float
    bulk_modulus: float
    mode_frequency: float
    mode_damping_ratio: float
    detail_rms: Levels
    delta_fixed: Levels
    delta_matched: Levels
    status: str
    message: str

    @property
    def is_sealed(self) -> bool:
        """Whether the row is a control without internal leakage."""
        return self.leakage_request == 0.0


@dataclass(frozen=True)
class SensitivityTable:
    """All rows, sealed ones first, and what they are read against.

    Attributes
    ----------
    name : str
        Name of the experiment.
    rows : tuple of TableRow
    bands : tuple of (float, float)
        Nominal band of d1, d2, … [Hz].
    normal_bulk_modulus : float
        β of the fixed baseline [Pa].
    """

    name: str
    rows: tuple[TableRow, ...]
    bands: tuple[tuple[float, float], ...]
    normal_bulk_modulus: float

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return len(self.bands)

    @property
    def label_names(self) -> list[str]:
        """Varied parameters besides leakage and EBM."""
        return list(self.rows[0].labels)

    @property
    def modes(self) -> dict[float, float]:
        """β [Pa] → f_h [Hz], in ascending order, of the runs that ended well."""
        ended = [row for row in self.rows if math.isfinite(row.mode_frequency)]
        return {row.bulk_modulus: row.mode_frequency for row in sorted(ended, key=_bulk_modulus)}


def largest_positive(levels: Sequence[float]) -> int | None:
    """Position of the largest value above zero; None where there is none."""
    best = max(
        range(len(levels)), key=lambda level: -math.inf if math.isnan(levels[level]) else levels[level]
    )
    return best if levels[best] > 0.0 else None


def level_name(level: int | None) -> str | None:
    """``d1`` for position 0, and so on."""
    return None if level is None else f"d{level + 1}"


def summarize_table(data: ExperimentData) -> SensitivityTable:
    """The table of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment as it was read.
    """
    fixed, matched = baseline_changes(data)
    names_of_labels = label_names(data)
    rows = [
        _row(
            data,
            position,
            names_of_labels,
            tuple(fixed[position].tolist()),
            tuple(matched[position].tolist()),
        )
        for position in range(data.n_run)
    ]
    rows.sort(key=lambda row: (not row.is_sealed, row.leakage_request))
    bands = tuple(level_bands(data.experiment.run.sampling_frequency, fixed.shape[1]))
    return SensitivityTable(data.experiment.name, tuple(rows), bands, normal_bulk_modulus(data))


def baseline_changes(data: ExperimentData) -> tuple[Any, Any]:
    """δ [%] of all runs against the fixed and the matched baseline, each of shape (n_run, n_level)."""
    rms = data.columns[names.DETAIL_RMS]
    with np.errstate(divide="ignore", invalid="ignore"):
        return (
            percentage_change(rms[data.columns[names.FIXED_BASELINE]], rms),
            percentage_change(rms[data.columns[names.MATCHED_BASELINE]], rms),
        )


def normal_bulk_modulus(data: ExperimentData) -> float:
    """β of the fixed baseline [Pa]."""
    return data.table.runs[data.table.fixed_baseline[0]].parameters.fluid.bulk_modulus


def leakage_request(data: ExperimentData, position: int) -> float:
    """Mean flow [m³/s] or K_i [m^3.5/kg^0.5] that a run asks for; 0 where it is sealed."""
    leakage = data.table.runs[position].parameters.leakage
    return leakage.internal_flow or leakage.internal_coefficient or 0.0


def label_names(data: ExperimentData) -> list[str]:
    """Varied parameters besides leakage and EBM."""
    usual = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")
    return [name for name in data.table.axes if name not in usual]


def _row(
    data: ExperimentData, position: int, labels: Sequence[str], fixed: Levels, matched: Levels
) -> TableRow:
    def number(name: str) -> float:
        return float(data.columns[name][position])

    level = number(names.LEAKAGE_LEVEL)
    parameters = data.table.runs[position].parameters
    return TableRow(
        run_id=str(data.columns[names.RUN_ID][position]),
        labels={name: parameters.told(name) for name in labels},
        leakage_request=leakage_request(data, position),
        leakage_flow=number(names.MEAN_LEAKAGE_FLOW) if math.isnan(level) else level,
        mean_leakage_flow=number(names.MEAN_LEAKAGE_FLOW),
        leakage_coefficient=number(names.LEAKAGE_COEFFICIENT),
        bulk_modulus=number(names.BULK_MODULUS),
        mode_frequency=number(names.MODE_FREQUENCY),
        mode_damping_ratio=number(names.MODE_DAMPING_RATIO),
        detail_rms=tuple(data.columns[names.DETAIL_RMS][position].tolist()),
        delta_fixed=fixed,
        delta_matched=matched,
        status=str(data.columns[names.STATUS][position]),
        message=str(data.columns[names.MESSAGE][position]),
    )


def _bulk_modulus(row: TableRow) -> float:
    return row.bulk_modulus


def label_header(name: str) -> str:
    """A varied parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
