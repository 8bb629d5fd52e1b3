"""Issues about the numbers of a record: estimates that no machine has, and models that do not explain it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from hydrofdi.errors import Issue
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


def doubts_of(
    indicator: Indicator[Any],
    values: Mapping[str, Array],
    prefix: str = "",
    fits: Mapping[str, float] | None = None,
) -> list[tuple[Issue, ...]]:
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
    found: list[list[Issue]] = [[] for _ in next(iter(own.values()), ())]
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


def _doubt(output: Output, value: float, high: float, prefix: str) -> Issue:
    name, shown = prefix + output.name, shown_quantity(value, output.unit)
    if output.is_fit:
        text = f"{name} = {shown} exceeds {high:.3g}: the model does not explain this machine"
        return Issue(text, name, kind="misfit")
    if output.is_positive and not value > 0.0:
        return Issue(f"{name} is not positive: {CAUSES}", name, kind="not_positive")
    return Issue(f"{name} = {shown} is physically impossible: {CAUSES}", name, kind="impossible")


def summaries(found: Iterable[Issue], n_record: int) -> Iterator[str]:
    """A sentence on each doubtful output, with the number of its records and the first reason.

    Parameters
    ----------
    found : iterable of Issue
        Of all records.
    n_record : int
        Number of records with numbers.
    """
    of: dict[str, list[Issue]] = {}
    for doubt in found:
        of.setdefault(doubt.where, []).append(doubt)
    for some in of.values():
        yield f"doubtful: {len(some):,} of {n_record:,} records, such as {some[0].message}"
