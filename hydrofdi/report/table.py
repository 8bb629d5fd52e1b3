"""Table 3: percentage change of the detail coefficients over leakage and EBM, with its controls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    labels : dict
        Further swept parameters → their values in SI.
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

    labels: dict[str, Any]
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
        return self.leakage_coefficient == 0.0


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
        """Swept parameters besides leakage and EBM."""
        return list(self.rows[0].labels)

    @property
    def modes(self) -> dict[float, float]:
        """β [Pa] → f_h [Hz], of the rows that did not fail."""
        known = [row for row in self.rows if math.isfinite(row.mode_frequency)]
        return {row.bulk_modulus: row.mode_frequency for row in sorted(known, key=_bulk_modulus)}


def largest_positive(levels: Sequence[float]) -> int | None:
    """Position of the largest value above zero; None where there is none."""
    best = max(
        range(len(levels)), key=lambda level: -math.inf if math.isnan(levels[level]) else levels[level]
    )
    return best if levels[best] > 0.0 else None


def summarize_table(data: ExperimentData) -> SensitivityTable:
    """The table of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment file as it was read.
    """
    columns, experiment = data.columns, data.experiment
    rms = columns[names.DETAIL_RMS]
    with np.errstate(divide="ignore", invalid="ignore"):
        fixed = percentage_change(rms[columns[names.FIXED_BASELINE]], rms)
        matched = percentage_change(rms[columns[names.MATCHED_BASELINE]], rms)
    rows = [_row(data, position, fixed[position], matched[position]) for position in range(data.n_run)]
    rows.sort(key=lambda row: (not row.is_sealed, row.leakage_flow))
    sampling_frequency = experiment.run.sampling_frequency
    normal = data.table.runs[data.table.fixed_baseline[0]].parameters.fluid.bulk_modulus
    bands = tuple(level_bands(sampling_frequency, rms.shape[1]))
    return SensitivityTable(experiment.name, tuple(rows), bands, normal)


def _row(
    data: ExperimentData, position: int, fixed: NDArray[np.float64], matched: NDArray[np.float64]
) -> TableRow:
    def number(name: str) -> float:
        return float(data.columns[name][position])

    level = number(names.LEAKAGE_LEVEL)
    parameters = data.table.runs[position].parameters
    return TableRow(
        labels={name: parameters.value(name) for name in _label_names(data)},
        leakage_flow=number(names.MEAN_LEAKAGE_FLOW) if math.isnan(level) else level,
        mean_leakage_flow=number(names.MEAN_LEAKAGE_FLOW),
        leakage_coefficient=number(names.LEAKAGE_COEFFICIENT),
        bulk_modulus=number(names.BULK_MODULUS),
        mode_frequency=number(names.MODE_FREQUENCY),
        mode_damping_ratio=number(names.MODE_DAMPING_RATIO),
        detail_rms=tuple(data.columns[names.DETAIL_RMS][position].tolist()),
        delta_fixed=tuple(fixed.tolist()),
        delta_matched=tuple(matched.tolist()),
        status=str(data.columns[names.STATUS][position]),
        message=str(data.columns[names.MESSAGE][position]),
    )


def _label_names(data: ExperimentData) -> list[str]:
    usual = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")
    return [name for name in data.table.axes if name not in usual]


def _bulk_modulus(row: TableRow) -> float:
    return row.bulk_modulus


def label_header(name: str) -> str:
    """A swept parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
