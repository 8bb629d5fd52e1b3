"""The runs of an experiment as rows: RMS of the details, and their change against both baselines."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.parameters import parameter_unit
from hydrofdi.store import ExperimentData, names
from hydrofdi.transforms.change import percentage_change
from hydrofdi.transforms.wavelet import level_bands

EXTERNAL = "leakage.external_coefficient"
"""How the parameters of external leakage begin."""

ROUNDING = 1e-9
"""A healthy RMS below this share of the record's largest pressure is rounding: no δ is taken against it."""

_NUMBERS = (
    names.LEAKAGE_LEVEL, names.MEAN_LEAKAGE_FLOW, names.LEAKAGE_COEFFICIENT, names.BULK_MODULUS,
    names.MODE_FREQUENCY, names.MODE_DAMPING_RATIO, names.MEAN_CHAMBER_1_PRESSURE,
    *names.EXTERNAL_LEAKAGE_FLOWS,
)  # fmt: skip
_TEXTS = (names.RUN_ID, names.STATUS, names.MESSAGE, names.VERDICT)

Levels = tuple[float, ...]
"""One number per wavelet level, d1 first; NaN where a run failed."""


@dataclass(frozen=True)
class LevelChanges:
    """One kind of coefficient of a run.

    Attributes
    ----------
    rms : tuple of float
        RMS of each level [Pa].
    fixed, matched : tuple of float
        δ [%] against the baseline's conditions, and against the sealed actuator in the run's own conditions.
    """

    rms: Levels
    fixed: Levels
    matched: Levels


@dataclass(frozen=True)
class ExternalLeakage:
    """Leakage out of chamber 1 and chamber 2: K_e [m³/(s·Pa)] and mean flows [m³/s]."""

    coefficients: tuple[float, float]
    flows: tuple[float, float]


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
    details, approximations : LevelChanges
        d1, d2, … and a1, a2, … of P_1, as configured.
    settled_details, settled_approximations : LevelChanges
        The same of the settled record.
    position : int
        Row in the experiment.
    external : ExternalLeakage
        Leakage out of the chambers.
    mean_pressure : float
        Mean of P_1 [Pa].
    status, message : str
        How the run ended.
    verdict : str
        How far it can be believed; its status where it did not end well.
    doubt_numbers : dict
        Word of a verdict → the number behind it.
    leaks_out_more : bool
        Whether its chambers leak more than those of its healthy run.
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
    external: ExternalLeakage
    mean_pressure: float
    status: str
    message: str
    verdict: str
    doubt_numbers: dict[str, float]
    leaks_out_more: bool = False

    @property
    def detail_rms(self) -> Levels:
        """RMS of d1, d2, … [Pa]."""
        return self.details.rms

    @property
    def delta_fixed(self) -> Levels:
        """δ of the details against the fixed baseline [%]."""
        return self.details.fixed

    @property
    def delta_matched(self) -> Levels:
        """δ of the details against the matched baseline [%]."""
        return self.details.matched

    @property
    def doubts(self) -> tuple[str, ...]:
        """What the numbers of a run that ended well have to be read with."""
        sound = self.status != "ok" or self.verdict in ("", "ok")
        return () if sound else tuple(self.verdict.split(", "))

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
    baseline : dict
        Dotted parameters of the fixed baseline.
    """

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
    def has_doubts(self) -> bool:
        """Whether any run that ended well has a verdict other than ``ok``."""
        return any(row.doubts for row in self.rows)

    @cached_property
    def has_settled(self) -> bool:
        """Whether any run has features of its settled record."""
        return any(math.isfinite(row.settled_details.rms[0]) for row in self.rows)

    @property
    def varies_external(self) -> bool:
        """Whether the runs differ in their external leakage."""
        return any(name.startswith(EXTERNAL) for name in self.label_names)

    @property
    def modes(self) -> dict[float, tuple[float, float]]:
        """β [Pa] → least and largest f_h [Hz] of the runs that ended well, in ascending order."""
        found: dict[float, list[float]] = {}
        for row in sorted(self.rows, key=_bulk_modulus):
            if math.isfinite(row.mode_frequency):
                found.setdefault(row.bulk_modulus, []).append(row.mode_frequency)
        return {beta: (min(frequencies), max(frequencies)) for beta, frequencies in found.items()}


def largest_positive(levels: Sequence[float]) -> int | None:
    """Position of the largest value above zero; None where there is none."""
    best = max(
        range(len(levels)), key=lambda level: -math.inf if math.isnan(levels[level]) else levels[level]
    )
    return best if levels[best] > 0.0 else None


def level_name(level: int | None) -> str | None:
    """``d1`` for position 0, and so on."""
    return None if level is None else f"d{level + 1}"


_FEATURES = (
    names.DETAIL_RMS,
    names.APPROXIMATION_RMS,
    names.SETTLED_DETAIL_RMS,
    names.SETTLED_APPROXIMATION_RMS,
)


def summarize_table(data: ExperimentData) -> SensitivityTable:
    """The table of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment as it was read.
    """
    rows = sorted(_rows(data), key=lambda row: (not row.is_sealed, row.leakage_request))
    n_level = data.columns[names.DETAIL_RMS].shape[1]
    return SensitivityTable(
        name=data.experiment.name,
        rows=tuple(rows),
        bands=tuple(level_bands(data.experiment.run.sampling_frequency, n_level)),
        normal_bulk_modulus=normal_bulk_modulus(data),
        baseline=data.experiment.baseline,
    )


def _changes(data: ExperimentData, name: str) -> list[LevelChanges]:
    """RMS and δ of one kind of coefficient, run by run."""
    arrays = (data.columns[name], *baseline_changes(data, name))
    return [
        LevelChanges(*map(tuple, levels))
        for levels in zip(*(array.tolist() for array in arrays), strict=True)
    ]


def baseline_changes(data: ExperimentData, name: str = names.DETAIL_RMS) -> tuple[Any, Any]:
    """δ [%] of all runs against the fixed and the matched baseline, each in the shape of the variable `name`.

    NaN where a run failed, or where the RMS of the healthy one is rounding.
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
    """β of the fixed baseline [Pa]; of the baseline's conditions where no run is healthy."""
    row = data.fixed_baseline[0]
    if row == names.NO_BASELINE:
        return float(data.experiment.baseline["fluid.bulk_modulus"])
    return float(data.columns[names.BULK_MODULUS][row])


def leaks_out_more(data: ExperimentData) -> NDArray[np.bool_]:
    """Whether the chambers of each run leak more than those of its healthy run; scenarios count as they are.

    Modes are of internal leakage and EBM; what leaks out besides is another fault.
    """
    coefficients = np.array(_external_coefficients(data))
    healthy = coefficients[np.maximum(data.matched_baseline, 0)]
    is_compared = (data.matched_baseline != names.NO_BASELINE) & (not data.experiment.has_scenarios)
    more: NDArray[np.bool_] = is_compared & (coefficients != healthy).any(axis=1)
    return more


def _external_coefficients(data: ExperimentData) -> list[tuple[float, float]]:
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


def _rows(data: ExperimentData) -> Iterator[TableRow]:
    """The rows in the order of the runs, replicates left out."""
    numbers = {name: data.columns[name].tolist() for name in (*_NUMBERS, *names.DOUBTS.values())}
    texts = {name: data.columns[name].astype(str).tolist() for name in _TEXTS}
    labels = {name: data.values(name) for name in label_names(data)}
    features = [_changes(data, name) for name in _FEATURES]
    requests, coefficients = data.leakage_requests.tolist(), _external_coefficients(data)
    flows = list(zip(*(numbers[name] for name in names.EXTERNAL_LEAKAGE_FLOWS), strict=True))
    of_replicate = data.replicate_of.tolist()
    for k, more in enumerate(leaks_out_more(data).tolist()):
        if of_replicate[k] != names.NO_BASELINE:
            continue
        status, level = texts[names.STATUS][k], numbers[names.LEAKAGE_LEVEL][k]
        yield TableRow(
            run_id=texts[names.RUN_ID][k],
            labels={name: values[k] for name, values in labels.items()},
            leakage_request=requests[k],
            leakage_flow=numbers[names.MEAN_LEAKAGE_FLOW][k] if math.isnan(level) else level,
            mean_leakage_flow=numbers[names.MEAN_LEAKAGE_FLOW][k],
            leakage_coefficient=numbers[names.LEAKAGE_COEFFICIENT][k],
            bulk_modulus=numbers[names.BULK_MODULUS][k],
            mode_frequency=numbers[names.MODE_FREQUENCY][k],
            mode_damping_ratio=numbers[names.MODE_DAMPING_RATIO][k],
            details=features[0][k],
            approximations=features[1][k],
            settled_details=features[2][k],
            settled_approximations=features[3][k],
            position=k,
            external=ExternalLeakage(coefficients[k], flows[k]),
            mean_pressure=numbers[names.MEAN_CHAMBER_1_PRESSURE][k],
            status=status,
            message=texts[names.MESSAGE][k],
            verdict=texts[names.VERDICT][k] if status == "ok" else status,
            doubt_numbers={word: numbers[name][k] for word, name in names.DOUBTS.items()},
            leaks_out_more=more,
        )


def _bulk_modulus(row: TableRow) -> float:
    return row.bulk_modulus


def label_header(name: str) -> str:
    """A varied parameter with its SI unit, e.g. ``friction.viscous [N·s/m]``."""
    unit = parameter_unit(name)
    return f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
