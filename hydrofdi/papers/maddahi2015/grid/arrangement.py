"""The runs of an experiment as a grid of modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.papers.maddahi2015.grid.crossing import missing_baseline, missing_grid
from hydrofdi.papers.maddahi2015.grid.modes import ABSENT, ModeGrid, gathered
from hydrofdi.report.runs import (
    baseline_changes,
    label_names,
    leaks_out_more,
    normal_bulk_modulus,
)
from hydrofdi.store import ExperimentData
from hydrofdi.store.layout import names


def arrange_modes(data: ExperimentData) -> ModeGrid:
    """The grid of an experiment.

    Parameters
    ----------
    data : ExperimentData
        An experiment as it was read.
    """
    kept = np.flatnonzero(~leaks_out_more(data) & (data.replicate_of == names.NO_BASELINE))
    axes = _axes(data, kept)
    lack = missing_baseline(data) or missing_grid(data.experiment, axes.shape, len(kept))
    if lack:
        kept = np.array([max(0, data.fixed_baseline[0])])
        axes = _axes(data, kept)
    positions = np.full(axes.shape, ABSENT)
    positions[axes.places] = kept
    _share_sealed_runs(positions, data.matched_baseline)
    normal = 0 if lack else axes.bulk_moduli.index(normal_bulk_modulus(data))
    fixed, matched = baseline_changes(data)
    return ModeGrid(
        scenarios=axes.scenarios,
        leakage_flows=tuple(_flow(data, leaky, normal) for leaky in positions[0, 1:]),
        bulk_moduli=axes.bulk_moduli,
        normal=normal,
        positions=positions,
        fixed=gathered(fixed, positions),
        matched=gathered(matched, positions),
        lack=lack,
    )


@dataclass(frozen=True)
class _Axes:
    """Values of the axes of a grid, and where its runs lie: indices along each axis."""

    scenarios: tuple[dict[str, Any], ...]
    shape: tuple[int, int, int]
    bulk_moduli: tuple[float, ...]
    places: tuple[NDArray[np.int64], ...]


def _axes(data: ExperimentData, kept: NDArray[np.int64]) -> _Axes:
    values = {name: _picked(data.values(name), kept) for name in label_names(data)}
    labels = [name for name in values if len(kept) == data.n_run or len(set(values[name])) > 1]
    scenarios = list(zip(*(values[name] for name in labels), strict=True)) or [()] * len(kept)
    requests = data.leakage_requests[kept].tolist()
    moduli = data.columns[names.BULK_MODULUS][kept].tolist()
    scenario_order, request_order = list(dict.fromkeys(scenarios)), sorted({0.0, *requests})
    modulus_order = sorted(set(moduli))
    return _Axes(
        scenarios=tuple(dict(zip(labels, values, strict=True)) for values in scenario_order),
        shape=(len(scenario_order), len(request_order), len(modulus_order)),
        bulk_moduli=tuple(modulus_order),
        places=(
            _ranks(scenarios, scenario_order),
            _ranks(requests, request_order),
            _ranks(moduli, modulus_order),
        ),
    )


def _share_sealed_runs(positions: NDArray[np.int64], matched: NDArray[Any]) -> None:
    """Give scenarios without sealed runs of their own those that their leaky runs are compared with.

    What differs in the leakage alone, such as its law, is the same once the actuator is sealed.
    """
    for scenario, _, beta in np.argwhere(positions[:, :1] == ABSENT):
        leaky = positions[scenario, 1:, beta]
        if (leaky != ABSENT).any():
            positions[scenario, 0, beta] = matched[leaky[leaky != ABSENT][0]]


def _picked(values: list[Any], positions: NDArray[np.int64]) -> list[Any]:
    return [values[position] for position in positions]


def _ranks(values: Sequence[Any], order: Sequence[Any]) -> NDArray[np.int64]:
    rank = {value: position for position, value in enumerate(order)}
    return np.array([rank[value] for value in values])


def _flow(data: ExperimentData, positions: NDArray[np.int64], normal: int) -> float:
    """Leakage level of the runs of one leakage: as it was asked for, or as it is at the normal EBM."""
    position = positions[normal] if positions[normal] != ABSENT else positions[positions != ABSENT][0]
    asked = float(data.columns[names.LEAKAGE_LEVEL][position])
    return asked if asked == asked else float(data.columns[names.MEAN_LEAKAGE_FLOW][position])
