"""The runs of an experiment by the values of what varies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.report.fifths import MOST_VALUES, fifths
from hydrofdi.report.runs.table import label_header
from hydrofdi.report.wording import litres_per_minute, megapascal, plain
from hydrofdi.store import ExperimentData

_FLOW, _COEFFICIENT = "leakage.internal_flow", "leakage.internal_coefficient"
_MODULUS = "fluid.bulk_modulus"


@dataclass(frozen=True)
class Group:
    """Runs with one value, or one range of values.

    Attributes
    ----------
    value : float, str or None
        In SI; None for a range.
    text : str
    rows : ndarray of bool, shape (n_run,)
    """

    value: Any
    text: str
    rows: NDArray[np.bool_]


@dataclass(frozen=True)
class Axis:
    """A parameter that varies: its dotted name, a header with its unit, and its groups of runs."""

    name: str
    header: str
    groups: tuple[Group, ...]


def varied_axes(data: ExperimentData, kept: NDArray[np.bool_]) -> tuple[Axis, ...]:
    """The swept parameters with more than one value among the runs that are kept."""
    axes = [_axis(data, name, kept) for name in dict.fromkeys(data.swept_names)]
    return tuple(axis for axis in axes if len(axis.groups) > 1)


def _axis(data: ExperimentData, name: str, kept: NDArray[np.bool_]) -> Axis:
    is_leakage = name in INTERNAL_LEAKAGE_FORMS
    values = data.leakage_requests.tolist() if is_leakage else data.values(name)
    if name == _MODULUS:
        return Axis(name, "EBM [MPa]", _groups(values, kept, megapascal))
    if name == _FLOW:
        return Axis(name, "Leakage [L/min]", _groups(values, kept, _flow))
    if is_leakage:
        return Axis(name, "K_i [m^3.5/kg^0.5]", _groups(values, kept, _coefficient))
    return Axis(name, label_header(name), _groups(values, kept, plain))


def _flow(flow: float) -> str:
    return litres_per_minute(flow) if flow else "sealed"


def _coefficient(coefficient: float) -> str:
    return plain(coefficient) if coefficient else "sealed"


def _groups(values: list[Any], kept: NDArray[np.bool_], text: Callable[[Any], str]) -> tuple[Group, ...]:
    found = dict.fromkeys(value for value, is_kept in zip(values, kept, strict=True) if is_kept)
    if all(isinstance(value, int | float) for value in found):
        numbers = np.array(values, dtype=float)
        if len(found) > MOST_VALUES:
            return _fifths(numbers, kept, text)
        return tuple(Group(value, text(value), kept & (numbers == value)) for value in sorted(found))
    return tuple(
        Group(value, "–" if value is None else plain(value), kept & np.array([v == value for v in values]))
        for value in found
    )


def _fifths(
    values: NDArray[np.float64], kept: NDArray[np.bool_], text: Callable[[Any], str]
) -> tuple[Group, ...]:
    groups = []
    for part in fifths(values[kept]):
        rows = kept.copy()
        rows[kept] = part.members
        groups.append(Group(None, f"{text(part.low)} … {text(part.high)}", rows))
    return tuple(group for group in groups if group.rows.any())
