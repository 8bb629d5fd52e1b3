"""δ of all runs against both baselines, as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.report.runs.table import EXTERNAL
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.change import percentage_change

ROUNDING = 1e-9
"""A healthy RMS below this share of the record's largest pressure is rounding error and gives no δ."""


def baseline_changes(data: ExperimentData, name: str = names.DETAIL_RMS) -> tuple[Any, Any]:
    """δ [%] of all runs against the fixed and the matched baseline, each in the shape of the variable `name`.

    NaN if a run failed, or if the RMS of the healthy run is rounding error.
    """
    rms = data.columns[name]
    column = (-1, *[1] * (rms.ndim - 1))
    rounding = ROUNDING * data.columns[names.LARGEST_CHAMBER_1_PRESSURE].reshape(column)
    healthy = np.where(rms < rounding, np.nan, rms)
    fixed, matched = (
        np.where((rows == names.NO_BASELINE).reshape(column), np.nan, healthy[rows])
        for rows in (data.fixed_baseline, data.matched_baseline)
    )
    return percentage_change(fixed, rms), percentage_change(matched, rms)


def normal_bulk_modulus(data: ExperimentData) -> float:
    """β of the fixed baseline [Pa]; of the baseline's conditions if no run is healthy."""
    row = data.fixed_baseline[0]
    if row == names.NO_BASELINE:
        return float(data.experiment.baseline["fluid.bulk_modulus"])
    return float(data.columns[names.BULK_MODULUS][row])


def leaks_out_more(data: ExperimentData) -> NDArray[np.bool_]:
    """Whether the chambers of each run leak more than those of its healthy run; scenarios count as they are.

    Modes are combinations of internal leakage and EBM; additional external leakage is another fault.
    """
    coefficients = np.array(external_coefficients(data))
    healthy = coefficients[np.maximum(data.matched_baseline, 0)]
    is_compared = (data.matched_baseline != names.NO_BASELINE) & (not data.experiment.has_scenarios)
    more: NDArray[np.bool_] = is_compared & (coefficients != healthy).any(axis=1)
    return more


def external_coefficients(data: ExperimentData) -> list[tuple[float, float]]:
    """K_e of chamber 1 and 2 of each run [m³/(s·Pa)]."""
    either, *own = (data.values(f"{EXTERNAL}{chamber}") for chamber in ("", "_1", "_2"))
    first, second = (
        [common if value is None else value for value, common in zip(values, either, strict=True)]
        for values in own
    )
    return list(zip(first, second, strict=True))


def label_names(data: ExperimentData) -> list[str]:
    """Varied parameters besides leakage and EBM."""
    usual = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")
    return [name for name in data.swept_names if name not in usual]
