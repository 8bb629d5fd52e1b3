"""Doubts about the numbers of a record: estimates that no machine has, and models that do not explain it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from hydrofdi.indicators.contract import Indicator, Output
from hydrofdi.records import Array
from hydrofdi.settings.readable import shown_quantity

CAUSES = (
    "is a sign, the zero of the position or a constant of the actuator wrong, or are two channels swapped?"
)

POSITIVE = (0.0, None)
"""Possible values of a quantity that can only be positive."""

FLUID = (0.1e9, 3e9)
"""Bulk moduli of a fluid in a machine [Pa]."""

_ANY = (-math.inf, math.inf)

_DEVIATIONS = 4.0
"""Standard deviations by which an estimate must lie below its lowest possible value."""


@dataclass(frozen=True)
class Doubt:
    """Why the numbers of a record are doubtful.

    Attributes
    ----------
    name : str
        The output, with its prefix.
    text : str
        The reason in words, with the value.
    is_impossible : bool
        Whether no machine has such a value; else the model does not explain the record.
    is_not_positive : bool
        Whether the output can only be positive, and is negative or missing.
    """

    name: str
    text: str
    is_impossible: bool
    is_not_positive: bool


def doubts_of(
    indicator: Indicator[Any],
    values: Mapping[str, Array],
    prefix: str = "",
    fits: Mapping[str, float] | None = None,
) -> list[tuple[Doubt, ...]]:
    """Doubts about each record; none about records without any number.

    Parameters
    ----------
    indicator : Indicator
    values : mapping of str to ndarray, shape (n_record, ...)
        Its outputs by name; outputs that are not there are not checked.
    prefix : str
        Prefix of these names.
    fits : mapping of str to float, optional
        Largest values with which the model explains a record, where they are not those of the outputs.
    """
    outputs = [each for each in indicator.outputs if prefix + each.name in values and not each.dims]
    own = {each.name: values[prefix + each.name] for each in outputs}
    found: list[list[Doubt]] = [[] for _ in next(iter(own.values()), ())]
    is_measured = np.any([np.isfinite(array) for array in own.values()], axis=0) if own else np.array([])
    for output in outputs:
        if output.possible == (None, None):
            continue
        low, high = (
            end if given is None else given for given, end in zip(output.possible, _ANY, strict=True)
        )
        high = (fits or {}).get(output.name, high)
        value, slack = own[output.name], _DEVIATIONS * own[output.error] if output.error else 0.0
        is_possible = ~(value > high) if output.is_fit else (value >= low - slack) & (value <= high)
        for row in np.flatnonzero(is_measured & ~is_possible).tolist():
            found[row].append(_doubt(output, float(value[row]), high, prefix))
    return [tuple(each) for each in found]


def _doubt(output: Output, value: float, high: float, prefix: str) -> Doubt:
    name, shown = prefix + output.name, shown_quantity(value, output.unit)
    if output.is_fit:
        text = f"{name} = {shown} exceeds {high:.3g}: the model does not explain this machine"
        return Doubt(name, text, False, False)
    if output.is_positive and not value > 0.0:
        return Doubt(name, f"{name} is not positive: {CAUSES}", True, True)
    return Doubt(name, f"{name} = {shown} is physically impossible: {CAUSES}", True, False)


def summaries(found: Iterable[Doubt], n_record: int) -> Iterator[str]:
    """A sentence on each doubtful output, with the number of its records and the first reason.

    Parameters
    ----------
    found : iterable of Doubt
        Of all records.
    n_record : int
        Number of records with numbers.
    """
    of: dict[str, list[Doubt]] = {}
    for doubt in found:
        of.setdefault(doubt.name, []).append(doubt)
    for some in of.values():
        yield f"doubtful: {len(some):,} of {n_record:,} records, such as {some[0].text}"
