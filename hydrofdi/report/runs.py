"""The runs of an experiment as rows: what they are, how they ended, and δ of their wavelet details."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.shown_values import ShownParameter, shown_parameter
from hydrofdi.quality.doubts import DOUBTS, Doubt, doubts_of
from hydrofdi.report.forms.numbers import finite
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names
from hydrofdi.transforms.change import percentage_change
from hydrofdi.transforms.wavelet import level_bands
from hydrofdi.units import convert

EXTERNAL = "leakage.external_coefficient"
"""Prefix of the parameters of external leakage."""

ROUNDING = 1e-9
"""A healthy RMS below this share of the record's largest pressure is rounding error and gives no δ."""

Levels = tuple[float, ...]
"""One number per wavelet level, d1 first; NaN if a run failed."""

KINDS = {
    "details": (names.DETAIL_RMS, "detail_rms", "delta"),
    "approximations": (names.APPROXIMATION_RMS, "approximation_rms", "approximation_delta"),
    "settled_details": (names.SETTLED_DETAIL_RMS, "settled_detail_rms", "settled_delta"),
    "settled_approximations": (
        names.SETTLED_APPROXIMATION_RMS,
        "settled_approximation_rms",
        "settled_approximation_delta",
    ),
}
"""Kind of coefficient → its variable, and how data for programs name its RMS and its δ."""


@dataclass(frozen=True)
class LevelChanges:
    """RMS [Pa] of one kind of coefficient of a run, and δ [%] against the fixed and the matched baseline."""

    rms: Levels
    fixed: Levels
    matched: Levels


@dataclass(frozen=True)
class TableRow:
    """A run, in SI and percent.

    `leakage_request` is the mean flow [m³/s] or K_i [m^3.5/kg^0.5] that was asked for, 0 if sealed;
    `leakage_flow` the level of the row [m³/s]: the flow that K_i was solved for, or else that of the run.
    `position` is its row in the experiment, `verdict` its reliability, or its status if it did not succeed.
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
    details: LevelChanges
    approximations: LevelChanges
    settled_details: LevelChanges
    settled_approximations: LevelChanges
    position: int
    external_coefficients: tuple[float, float]
    external_flows: tuple[float, float]
    mean_pressure: float
    status: str
    message: str
    verdict: str
    doubt_numbers: dict[str, float]
    leaks_out_more: bool = False

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """What of a run that succeeded."""
        return doubts_of(self.verdict)

    @property
    def is_sealed(self) -> bool:
        """Whether the row is a control without internal leakage."""
        return self.leakage_request == 0.0


@dataclass(frozen=True)
class RunTable:
    """All rows, sealed rows first, with the nominal band of each level [Hz] and their fixed baseline."""

    name: str
    rows: tuple[TableRow, ...]
    bands: tuple[tuple[float, float], ...]
    normal_bulk_modulus: float
    baseline: dict[str, Any]

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return len(self.bands)

    @property
    def label_names(self) -> list[str]:
        """Varied parameters besides leakage and EBM."""
        return list(self.rows[0].labels)

    @cached_property
    def shown_labels(self) -> dict[str, ShownParameter]:
        """Varied parameters besides leakage and EBM → how people read their values."""
        return {
            name: shown_parameter(name, (row.labels[name] for row in self.rows)) for name in self.label_names
        }

    @cached_property
    def has_settled(self) -> bool:
        """Whether any run has features of its settled record."""
        return any(math.isfinite(row.settled_details.rms[0]) for row in self.rows)

    @property
    def varies_external(self) -> bool:
        """Whether the runs differ in their external leakage."""
        return any(name.startswith(EXTERNAL) for name in self.label_names)


def run_table(data: ExperimentData) -> RunTable:
    """The table of an experiment, without replicates."""
    n_level = data.columns[names.DETAIL_RMS].shape[1]
    return RunTable(
        name=data.experiment.name,
        rows=tuple(_in_order(list(_rows(data)))),
        bands=tuple(level_bands(data.experiment.record.sampling_frequency, n_level)),
        normal_bulk_modulus=normal_bulk_modulus(data),
        baseline=data.experiment.baseline,
    )


def _in_order(rows: list[TableRow]) -> list[TableRow]:
    """Sealed rows first, then by leakage, EBM and further parameters; words in the order of the file."""
    labels = {name: [row.labels[name] for row in rows] for name in rows[0].labels}
    places = {
        name: {value: place for place, value in enumerate(dict.fromkeys(values))}
        for name, values in labels.items()
        if not all(isinstance(value, int | float) for value in values)
    }

    def key(row: TableRow) -> tuple[Any, ...]:
        others = (places[name][value] if name in places else value for name, value in row.labels.items())
        return (not row.is_sealed, row.leakage_request, row.bulk_modulus, *others)

    return sorted(rows, key=key)


def _rows(data: ExperimentData) -> Iterator[TableRow]:
    numbers = {
        field: data.columns[name].tolist()
        for field, name in {
            "mean_leakage_flow": names.MEAN_LEAKAGE_FLOW, "leakage_coefficient": names.LEAKAGE_COEFFICIENT,
            "bulk_modulus": names.BULK_MODULUS, "mode_frequency": names.MODE_FREQUENCY,
            "mode_damping_ratio": names.MODE_DAMPING_RATIO, "mean_pressure": names.MEAN_CHAMBER_1_PRESSURE,
        }.items()
    }  # fmt: skip
    run_ids, statuses, messages, verdicts = (
        data.columns[name].astype(str).tolist()
        for name in (names.RUN_ID, names.STATUS, names.MESSAGE, names.VERDICT)
    )
    doubts = {word: data.columns[doubt.number].tolist() for word, doubt in DOUBTS.items()}
    labels = {name: data.values(name) for name in label_names(data)}
    levels = {kind: _levels(data, variable) for kind, (variable, _, _) in KINDS.items()}
    requests, coefficients = data.leakage_requests.tolist(), external_coefficients(data)
    asked = data.columns[names.LEAKAGE_LEVEL].tolist()
    flows = np.stack([data.columns[name] for name in names.EXTERNAL_LEAKAGE_FLOWS], axis=-1).tolist()
    leaks_more = leaks_out_more(data).tolist()
    for k in np.flatnonzero(table_runs(data)).tolist():
        own = {field: values[k] for field, values in numbers.items()}
        yield TableRow(
            run_id=run_ids[k],
            labels={name: values[k] for name, values in labels.items()},
            leakage_request=requests[k],
            leakage_flow=own["mean_leakage_flow"] if math.isnan(asked[k]) else asked[k],
            **own,
            details=levels["details"][k],
            approximations=levels["approximations"][k],
            settled_details=levels["settled_details"][k],
            settled_approximations=levels["settled_approximations"][k],
            position=k,
            external_coefficients=coefficients[k],
            external_flows=(flows[k][0], flows[k][1]),
            status=statuses[k],
            message=messages[k],
            verdict=verdicts[k] if statuses[k] == "ok" else statuses[k],
            doubt_numbers={word: values[k] for word, values in doubts.items()},
            leaks_out_more=leaks_more[k],
        )


def _levels(data: ExperimentData, variable: str) -> list[LevelChanges]:
    arrays = (data.columns[variable], *baseline_changes(data, variable))
    return [LevelChanges(*map(tuple, run)) for run in zip(*(each.tolist() for each in arrays), strict=True)]


def table_runs(data: ExperimentData) -> NDArray[np.bool_]:
    """Which runs the table contains: swept runs and their baselines, without replicates."""
    return np.asarray(data.replicate_of == names.NO_BASELINE)


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


def largest_positive(levels: Sequence[float]) -> int | None:
    """Position of the largest value above zero; None if there is none."""
    known = {level: value for level, value in enumerate(levels) if value > 0.0}
    return max(known, key=known.__getitem__, default=None)


def level_name(level: int | None) -> str | None:
    """``d1`` for position 0, and so on."""
    return None if level is None else f"d{level + 1}"


def row_numbers(row: TableRow) -> dict[str, Any]:
    """Numbers of a run for programs, and for each level its RMS, δ, and the levels that lead."""
    numbers: dict[str, Any] = {
        "mean_chamber_1_pressure_Pa": finite(row.mean_pressure),
        "hydraulic_mode_Hz": finite(row.mode_frequency),
        "hydraulic_mode_damping_ratio": finite(row.mode_damping_ratio),
    }
    for kind, (_, rms, delta) in KINDS.items():
        found: LevelChanges = getattr(row, kind)
        numbers[f"{rms}_Pa"] = [finite(value) for value in found.rms]
        numbers[f"{delta}_fixed_percent"] = [finite(value) for value in found.fixed]
        numbers[f"{delta}_matched_percent"] = [finite(value) for value in found.matched]
    return numbers


def flow_numbers(row: TableRow) -> list[float | None]:
    """Level, mean internal flow, and mean flows out of both chambers [L/min]."""
    flows = (row.leakage_flow, row.mean_leakage_flow, *row.external_flows)
    return [finite(convert(flow, "L/min")) for flow in flows]
