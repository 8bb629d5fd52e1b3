"""The runs of an experiment, grouped by the values of varied parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import expand_runs
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS, ExperimentConfig
from hydrofdi.config.shown_values import shown_parameter
from hydrofdi.config.sweep import count_points
from hydrofdi.report.wording import litres_per_minute, shown_modulus
from hydrofdi.settings.readable import HOLE, K_I_UNIT, typeset
from hydrofdi.store.experiment_data import ExperimentData

_FLOW, _COEFFICIENT = "leakage.internal_flow", "leakage.internal_coefficient"
_MODULUS = "fluid.bulk_modulus"
_MANY = 2_000

MOST_VALUES = 12
"""Most different values that are shown one by one; more are divided into fifths."""

_FIFTHS = 5


def fifths(values: NDArray[np.float64]) -> list[tuple[float, float, NDArray[np.bool_]]]:
    """Values by size, in fifths of equal number: the ends of each, and which values belong to it."""
    edges = np.quantile(values, np.linspace(0.0, 1.0, _FIFTHS + 1))
    rank = np.searchsorted(np.sort(values), values, side="right") - 1
    place = np.minimum(_FIFTHS * rank // max(values.size - 1, 1), _FIFTHS - 1)
    return [(float(edges[k]), float(edges[k + 1]), place == k) for k in range(_FIFTHS)]


@dataclass(frozen=True)
class Group:
    """Runs with one value, or one range of values.

    Attributes
    ----------
    value : float, str or None
        In SI; None for a range.
    text : str
        In the unit of the header of the axis.
    rows : ndarray of bool, shape (n_run,)
    """

    value: Any
    text: str
    rows: NDArray[np.bool_]


@dataclass(frozen=True)
class Axis:
    """A parameter that varies.

    Attributes
    ----------
    name : str
        Dotted name.
    header : str
        What people read, with its unit, such as ``supply.pressure [MPa]``.
    groups : tuple of Group
        Runs by value in ascending order; by fifths of the values if there are many.
    numbers : ndarray, shape (n_run,), or None
        The values in SI; NaN for runs that belong to no group. None if the values are words.
    text : callable
        Value in SI → what people read under the header.
    """

    name: str
    header: str
    groups: tuple[Group, ...]
    numbers: NDArray[np.float64] | None
    text: Callable[[Any], str]

    @property
    def drawn(self) -> NDArray[np.float64] | None:
        """The numbers if the groups are ranges of them."""
        return self.numbers if self.groups[0].value is None else None


def swept_runs(data: ExperimentData) -> NDArray[np.bool_]:
    """Runs that the experiment requests; the others were added as healthy baselines."""
    return np.arange(data.n_run) < _count_swept(data.experiment)


def _count_swept(experiment: ExperimentConfig) -> int:
    """Runs of the sweep. Many unconditional points are taken to be different: expanding is slow."""
    blocks = (experiment.ensemble, experiment.sweep)
    n_point = prod(count_points(block) for block in blocks)
    if n_point > _MANY and not any(block.where or block.union for block in blocks):
        return n_point
    return expand_runs(experiment).n_swept


def varied_axes(data: ExperimentData, kept: NDArray[np.bool_]) -> tuple[Axis, ...]:
    """The swept parameters with more than one value among the runs that are kept."""
    axes = [_axis(data, name, kept) for name in dict.fromkeys(data.experiment.varied_names)]
    return tuple(axis for axis in axes if len(axis.groups) > 1)


def _axis(data: ExperimentData, name: str, kept: NDArray[np.bool_]) -> Axis:
    is_leakage = name in INTERNAL_LEAKAGE_FORMS
    values = data.leakage_requests.tolist() if is_leakage else data.values(name)
    if name == _MODULUS:
        return _made(name, f"EBM [{shown_modulus().unit}]", values, kept, shown_modulus().text)
    if is_leakage:
        is_flow = name == _FLOW
        header = "Leakage [L/min]" if is_flow else f"K_i [{typeset(K_I_UNIT)}]"
        number = litres_per_minute if is_flow else "{:.4g}".format
        return _made(name, header, values, kept, lambda value: number(value) if value else "sealed")
    shown = shown_parameter(name, values)
    return _made(name, shown.header, values, kept, shown.text)


def _made(
    name: str, header: str, values: list[Any], kept: NDArray[np.bool_], text: Callable[[Any], str]
) -> Axis:
    found = dict.fromkeys(value for value, is_kept in zip(values, kept, strict=True) if is_kept)
    if all(isinstance(value, int | float) for value in found):
        numbers = np.array([v if isinstance(v, int | float) else np.nan for v in values], dtype=float)
        numbers[~kept] = np.nan
        if len(found) > MOST_VALUES:
            ranges = []
            for low, high, members in fifths(numbers[kept]):
                rows = kept.copy()
                rows[kept] = members
                ranges.append(Group(None, f"{text(low)} … {text(high)}", rows))
            return Axis(name, header, tuple(each for each in ranges if each.rows.any()), numbers, text)
        groups = (Group(value, text(value), numbers == value) for value in sorted(found))
        return Axis(name, header, tuple(groups), numbers, text)
    words = (
        Group(value, HOLE if value is None else text(value), kept & np.array([v == value for v in values]))
        for value in found
    )
    return Axis(name, header, tuple(words), None, text)
