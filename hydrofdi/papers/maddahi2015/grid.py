"""The leaky modes of an experiment as arrays over scenarios, leakages, EBM and levels.

A *scenario* is one set of values of everything that varies besides leakage and EBM: an experiment without
such parameters has a single scenario, an ensemble has thousands. Claims and controls are evaluated on all of
them at once. The sentences of the paper compare modes that share a leakage or an EBM; runs whose leakage or
EBM is drawn from a range share none and form no grid.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.report.runs import Array, baseline_changes, label_names, leaks_out_more, normal_bulk_modulus
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.layout import names

ABSENT = -1
"""Position of a run that the experiment does not ask for."""

_FEW_CELLS, _CELLS_PER_RUN = 10_000, 4
"""A grid has few cells in all, or few for each of its runs."""

Mode = tuple[int, int]
"""Positions of a leakage and of an EBM in a grid."""


@dataclass(frozen=True)
class ModeGrid:
    """δ of all modes.

    Attributes
    ----------
    scenarios : tuple of dict
        Varied parameter → value in SI, for each scenario.
    leakage_flows : tuple of float
        Leakage levels [m³/s], ascending, without the sealed one; at the normal EBM where K_i itself is given.
    positions : ndarray of int, shape (n_scenario, 1 + n_leakage, n_bulk_modulus)
        Rows of the runs in the experiment, the sealed ones first; ``ABSENT`` if there is none.
    fixed, matched : ndarray, shape (n_scenario, 1 + n_leakage, n_bulk_modulus, n_level)
        δ [%] against the fixed and the matched baseline; NaN if a run is absent, failed or missing.
    lack : str
        Why there are no modes to compare, as a sentence: it then holds a single run.
    """

    scenarios: tuple[dict[str, Any], ...]
    leakage_flows: tuple[float, ...]
    bulk_moduli: tuple[float, ...]
    normal: int
    positions: NDArray[np.int64]
    fixed: Array
    matched: Array
    lack: str = ""

    @property
    def n_level(self) -> int:
        """Number of wavelet levels."""
        return int(self.fixed.shape[-1])

    @property
    def leaky(self) -> Array:
        """δ against the fixed baseline of the leaky modes."""
        return self.fixed[:, 1:]

    def modes(self, leakage: int | None = None, bulk_modulus: int | None = None) -> list[Mode]:
        """The leaky modes that all scenarios contain; all, or those of one leakage or EBM."""
        planned = np.argwhere((self.positions[:, 1:] > ABSENT).all(axis=0)).tolist()
        return [(q, b) for q, b in planned if leakage in (None, q) and bulk_modulus in (None, b)]

    @property
    def raised(self) -> list[int]:
        """Positions of the β above the normal one."""
        return list(range(self.normal + 1, len(self.bulk_moduli)))

    def holding(self, fixed: Array, matched: Array) -> ModeGrid:
        """The same modes with other δ of all runs, shape (n_run, n_level)."""
        absent = (self.positions == ABSENT)[..., None]
        fixed, matched = (np.where(absent, np.nan, each[self.positions]) for each in (fixed, matched))
        return replace(self, fixed=fixed, matched=matched)


def arrange_modes(data: ExperimentData) -> ModeGrid:
    """The grid of an experiment."""
    kept = np.flatnonzero(~leaks_out_more(data))
    scenarios, moduli, places = _axes(data, kept)
    if lack := _lack(data, tuple(int(of_axis.max()) + 1 for of_axis in places), len(kept)):
        kept = np.array([max(0, data.fixed_baseline[0])])
        scenarios, moduli, places = _axes(data, kept)
    positions = np.full([int(of_axis.max()) + 1 for of_axis in places], ABSENT)
    positions[places] = kept
    # what differs in the leak alone, such as its law, is the same once the actuator is sealed
    for scenario, _, beta in np.argwhere(positions[:, :1] == ABSENT):
        leaky = positions[scenario, 1:, beta]
        if (leaky != ABSENT).any():
            positions[scenario, 0, beta] = data.matched_baseline[leaky[leaky != ABSENT][0]]
    normal = 0 if lack else moduli.index(normal_bulk_modulus(data))
    flows = tuple(_flow(data, leaky, normal) for leaky in positions[0, 1:])
    nothing = np.empty(0)
    grid = ModeGrid(tuple(scenarios), flows, tuple(moduli), normal, positions, nothing, nothing, lack)
    return grid.holding(**baseline_changes(data))


def _axes(
    data: ExperimentData, kept: NDArray[np.int64]
) -> tuple[list[dict[str, Any]], list[float], tuple[NDArray[np.int64], ...]]:
    """Scenarios and β, and where runs lie: indices along scenario, leakage and EBM."""
    values = {name: np.array(data.values(name), dtype=object)[kept].tolist() for name in label_names(data)}
    labels = [name for name in values if len(kept) == data.n_run or len(set(values[name])) > 1]
    found = list(zip(*(values[name] for name in labels), strict=True)) or [()] * len(kept)
    order = {scenario: place for place, scenario in enumerate(dict.fromkeys(found))}
    _, leakage = np.unique([0.0, *data.leakage_requests[kept]], return_inverse=True)
    moduli, modulus = np.unique(data.columns[names.BULK_MODULUS][kept], return_inverse=True)
    places = (np.array([order[scenario] for scenario in found]), leakage[1:], modulus)
    return [dict(zip(labels, each, strict=True)) for each in order], moduli.tolist(), places


def _flow(data: ExperimentData, positions: NDArray[np.int64], normal: int) -> float:
    """Leakage level of the runs of one leakage: as it was asked for, or as it is at the normal EBM."""
    position = positions[normal] if positions[normal] != ABSENT else positions[positions != ABSENT][0]
    asked = float(data.columns[names.LEAKAGE_LEVEL][position])
    return asked if asked == asked else float(data.columns[names.MEAN_LEAKAGE_FLOW][position])


def _lack(data: ExperimentData, shape: tuple[int, ...], n_run: int) -> str:
    """Why an experiment has no grid of modes; empty if it has one."""
    if (data.fixed_baseline == names.NO_BASELINE).all():
        return "Without a healthy run to compare with, the claims are not evaluated."
    drawn = data.experiment.sweep.drawn | data.experiment.ensemble.drawn
    is_drawn = drawn & {"fluid.bulk_modulus", *INTERNAL_LEAKAGE_FORMS}
    if not is_drawn and np.prod(shape) <= max(_FEW_CELLS, _CELLS_PER_RUN * n_run):
        return ""
    return (
        "Leakage and EBM do not form a grid of modes: they are drawn from a range, or too few runs share"
        " them. The claims are not evaluated."
    )
