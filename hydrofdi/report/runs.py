"""The runs of an experiment as rows of a table: what they are, how they ended, and δ of their details."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.values import modulus_column, shown_modulus, shown_parameter
from hydrofdi.settings.messages import HOLE, convert
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.results import external_coefficients
from hydrofdi.tables.table import Column
from hydrofdi.transforms import level_bands, percentage_change

Array = NDArray[np.float64]

EXTERNAL = "leakage.external_coefficient"
"""Prefix of the parameters of external leakage."""

_CHAMBERS = {f"{EXTERNAL}_1": 0, f"{EXTERNAL}_2": 1}

ROUNDING = 1e-9
"""A healthy RMS below this share of the record's largest pressure is rounding error and gives no δ."""


@dataclass(frozen=True)
class ReportedRuns:
    """Runs of an experiment, by `positions` in it, and the parameters besides leakage and EBM that vary.

    ``table[name]`` is a variable of the experiment file for these runs.
    """

    data: ExperimentData
    positions: NDArray[np.int64]
    label_names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.data.columns[name][self.positions]

    def of(self, rows: Any) -> ReportedRuns:
        """Some of the rows: a mask, indices or a slice."""
        return replace(self, positions=self.positions[rows])

    def texts(self, name: str) -> list[str]:
        """A variable of words."""
        words: list[str] = self[name].astype(str).tolist()
        return words

    def values(self, name: str) -> list[Any]:
        """Values of a dotted parameter in SI."""
        values = self.data.values(name)
        return [values[position] for position in self.positions.tolist()]

    def changes(self, baseline: str, name: str = names.DETAIL_RMS) -> Array:
        """δ [%] of an RMS against the fixed or the matched baseline, shape (n_row, n_level)."""
        changes: Array = baseline_changes(self.data, name)[baseline][self.positions]
        return changes

    @property
    def verdicts(self) -> list[str]:
        """Reliability of each run, or its status if it did not succeed."""
        pairs = zip(self.texts(names.STATUS), self.texts(names.VERDICT), strict=True)
        return [verdict if status == "ok" else status for status, verdict in pairs]

    @property
    def labels(self) -> list[dict[str, Any]]:
        """Varied parameter besides leakage and EBM → value, for each row."""
        columns = {name: self.values(name) for name in self.label_names}
        return [{name: own[k] for name, own in columns.items()} for k in range(len(self))]

    @property
    def leakage_requests(self) -> Array:
        """Mean flow [m³/s] or K_i [m^3.5/kg^0.5] that was asked for, 0 if sealed."""
        return self.data.leakage_requests[self.positions]

    @property
    def is_sealed(self) -> NDArray[np.bool_]:
        """Whether a row is a control without internal leakage."""
        return np.asarray(self.leakage_requests == 0.0)

    @property
    def leakage_flows(self) -> Array:
        """Level of each row [m³/s]: the flow that K_i was solved for, or else that of the run."""
        asked = self[names.LEAKAGE_LEVEL]
        return np.where(np.isnan(asked), self[names.MEAN_LEAKAGE_FLOW], asked)

    @property
    def external_flows(self) -> Array:
        """Mean flows out of the chambers [m³/s], shape (n_row, 2)."""
        return np.stack([self[name] for name in names.EXTERNAL_LEAKAGE_FLOWS], axis=-1)

    @property
    def external_coefficients(self) -> Array:
        """K_e of the chambers [m³/(s·Pa)], shape (n_row, 2)."""
        return external_coefficients(self.data)[self.positions]

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return int(self.data.columns[names.DETAIL_RMS].shape[1])

    @property
    def has_settled(self) -> bool:
        """Whether any run has features of its settled record."""
        return bool(np.isfinite(self[names.SETTLED_DETAIL_RMS][:, 0]).any())

    def settled(self, name: str) -> str:
        """The variable of the settled records that stands for an RMS, if any run has settled."""
        return f"settled_{name}" if self.has_settled else name


def run_table(data: ExperimentData) -> ReportedRuns:
    """The runs: sealed ones first, by leakage, EBM, and what else varies."""
    table = ReportedRuns(data, np.arange(data.n_run), tuple(label_names(data)))
    others = (_sortable(table.values(name)) for name in reversed(table.label_names))
    return table.of(np.lexsort((*others, table[names.BULK_MODULUS], table.leakage_requests)))


def _sortable(values: list[Any]) -> Array:
    """Numbers as they are, words by their place in the file."""
    if all(isinstance(value, int | float) for value in values):
        return np.array(values, dtype=float)
    order = {value: index for index, value in enumerate(dict.fromkeys(values))}
    return np.array([order[value] for value in values], dtype=float)


def baseline_changes(data: ExperimentData, name: str = names.DETAIL_RMS) -> dict[str, Array]:
    """δ [%] of all runs against the fixed and the matched baseline, each in the shape of the variable `name`.

    NaN if a run failed, or if the RMS of the healthy run is rounding error.
    """
    rms = data.columns[name]
    rounding = ROUNDING * data.columns[names.LARGEST_CHAMBER_1_PRESSURE]
    # A healthy RMS of rounding errors would give changes of any size.
    known = np.where(rms < _along(rounding, rms), np.nan, rms)
    return {kind: percentage_change(of_healthy(known, rows), rms) for kind, rows in data.baselines.items()}


def of_healthy(values: Array, rows: NDArray[np.int64]) -> Array:
    """Values of the healthy run of each run, by its row; NaN without one."""
    # Rows of −1 read the last run, which the condition replaces.
    healthy: Array = np.where(_along(rows == names.NO_BASELINE, values), np.nan, values[rows])
    return healthy


def _along(of_run: NDArray[Any], values: Array) -> NDArray[Any]:
    """A number of each run, in as many dimensions as values of each."""
    return of_run.reshape(-1, *[1] * (values.ndim - 1))


def normal_bulk_modulus(data: ExperimentData) -> float:
    """β of the fixed baseline [Pa]; of the baseline's conditions if no run is healthy."""
    row = data.fixed_baseline[0]
    if row == names.NO_BASELINE:
        return float(data.experiment.baseline["fluid.bulk_modulus"])
    return float(data.columns[names.BULK_MODULUS][row])


def label_names(data: ExperimentData) -> list[str]:
    """Varied parameters besides leakage and EBM."""
    usual = ("fluid.bulk_modulus", "leakage.internal_flow", "leakage.internal_coefficient")
    return [name for name in data.experiment.varied_names if name not in usual]


def best_levels(delta: Array) -> NDArray[np.int64]:
    """Position of the largest δ above zero along the last axis; −1 if there is none."""
    # np.argmax would return the position of a NaN.
    known = np.where(np.isnan(delta), -np.inf, delta)
    best: NDArray[np.int64] = np.where(known.max(axis=-1) > 0.0, known.argmax(axis=-1), -1)
    return best


def level_names(levels: Sequence[int] | NDArray[np.int64]) -> list[str | None]:
    """``d1`` for position 0, and so on; None for −1."""
    return [None if level < 0 else f"d{level + 1}" for level in levels]


def modulus_text(bulk_modulus: float) -> str:
    """An EBM with its unit."""
    return f"{shown_modulus().text(bulk_modulus)} {shown_modulus().unit}"


def litres_per_minute(flow: float) -> str:
    """A leakage flow in L/min, without the unit, or a hole."""
    return hole_or(flow, f"{convert(flow, 'L/min'):.3g}")


def mode_name(leakage_flow: float, bulk_modulus: float) -> str:
    """A mode in words, e.g. ``0.12 L/min at 551 MPa``."""
    leakage = f"{litres_per_minute(leakage_flow)} L/min" if leakage_flow else "sealed"
    return f"{leakage} at {modulus_text(bulk_modulus)}"


def lead_columns(table: ReportedRuns) -> list[Column]:
    """What says which run a row is; external leakage of a chamber as the flow that it causes."""
    pairs = zip(table.leakage_requests.tolist(), table.leakage_flows.tolist(), strict=True)
    # of a missing run only K_i is known
    leakages = [
        "sealed" if not request else f"K_i {request:g}" if math.isnan(flow) else litres_per_minute(flow)
        for request, flow in pairs
    ]
    columns = [Column("Leakage [L/min]", leakages), modulus_column(table[names.BULK_MODULUS])]
    for name in table.label_names:
        shown = shown_parameter(name, values := table.values(name))
        if name in _CHAMBERS:
            flows = table.external_flows[:, _CHAMBERS[name]].tolist()
            texts = [litres_per_minute(flow) if k else "0" for k, flow in zip(values, flows, strict=True)]
            columns.append(Column(f"Out of {name[-1]} [L/min]", texts))
        else:
            columns.append(Column(shown.header, values, text=shown.text))
    return columns


def delta_columns(delta: Array) -> list[Column]:
    """δ of each level; the largest positive one of a row stands out."""
    strong = [np.flatnonzero(best_levels(delta) == level).tolist() for level in range(delta.shape[1])]
    return [
        Column(f"δd{level}", own, text=signed, strong=rows)
        for level, (own, rows) in enumerate(zip(delta.T, strong, strict=True), 1)
    ]


def band_sentence(table: ReportedRuns) -> str:
    """Bands of the levels."""
    bands = level_bands(table.data.experiment.record.sampling_frequency, table.n_level)
    return f"Bands [Hz]: {', '.join(f'd{k} {low:g}–{high:g}' for k, (low, high) in enumerate(bands, 1))}."


def hole_or(value: float, text: str) -> str:
    """A text, or a hole if its number is missing."""
    return HOLE if math.isnan(value) else text


def signed(value: float) -> str:
    """A number with its sign and one decimal; no sign where it rounds to zero; a hole if it is missing."""
    if math.isnan(value):
        return HOLE
    text = f"{value:+.1f}"
    return with_minus(text[1:] if float(text) == 0.0 else text)


def with_minus(number: str) -> str:
    """A number as people print it, with the minus sign of the field and not a hyphen."""
    return number.replace("-", "\N{MINUS SIGN}")


def kilopascal(pressure: float) -> str:
    """A pressure in kPa with two decimals, or a hole."""
    return hole_or(pressure, f"{convert(pressure, 'kPa'):.2f}")


def span_text(low: str, high: str) -> str:
    """A range that is not broken; one number where both ends print alike."""
    return low if low == high else f"{low} … {high}".replace(" ", "\N{NO-BREAK SPACE}")


def capitalized(sentence: str) -> str:
    """A sentence that starts with a capital, unless it starts with the name of a score such as dwt.d1."""
    first = sentence.partition(" ")[0].rstrip(".,;:")
    is_name = "_" in first or "." in first
    return sentence if is_name else f"{sentence[:1].upper()}{sentence[1:]}"


def joined(words: Sequence[str]) -> str:
    """``a, b and c``."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 2 else words)
