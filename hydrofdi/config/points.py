"""A sweep block → its points, as columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hydrofdi.config.request import parameter_quantity, validate_parameter
from hydrofdi.config.sweep import (
    SweepConfig,
    correlated,
    distinct_rows,
    is_unbounded,
    parse_condition,
    quantiles,
    unit_cube,
)
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import first_reason

NOMINAL = -1
"""Index of a point that does not set the parameter."""


@dataclass(frozen=True)
class Column:
    """The values of one parameter [SI], and the index of each point's; ``NOMINAL`` if the point sets none."""

    values: Sequence[Any]
    index: NDArray[np.int32]


@dataclass(frozen=True)
class Points:
    """Points of a sweep: dotted parameter → its column, each of length `n_point`."""

    n_point: int
    columns: dict[str, Column]

    def at(self, positions: NDArray[np.intp]) -> Points:
        """Some of the points."""
        columns = self.columns.items()
        return Points(
            len(positions), {name: Column(each.values, each.index[positions]) for name, each in columns}
        )

    def values(self, point: int, names: Sequence[str] | None = None) -> dict[str, Any]:
        """The values in SI that a point sets, by parameter."""
        columns = [(name, self.columns[name]) for name in (self.columns if names is None else names)]
        return {
            name: column.values[column.index[point]]
            for name, column in columns
            if column.index[point] != NOMINAL
        }


def count_points(block: SweepConfig) -> int:
    """Number of points of a block, before conditions remove any."""
    lengths = [len(values) for values in block.grid.values()]
    lengths += [len(values) for values in list(block.zip.values())[:1]]
    lengths += [block.sample.count] if block.sample else []
    lengths += [sum(count_points(part) for part in block.union)] if block.union else []
    return prod(lengths)


def sweep_points(block: SweepConfig, nominal: Callable[[str], Any], path: str) -> Points:
    """The points of a block, in order."""
    factors = [
        Points(len(values), {name: Column(values, np.arange(len(values), dtype=np.int32))})
        for name, values in block.grid.items()
    ]
    if block.zip:
        n_value = len(next(iter(block.zip.values())))
        index = np.arange(n_value, dtype=np.int32)
        factors.append(Points(n_value, {name: Column(values, index) for name, values in block.zip.items()}))
    if sample := block.sample:
        cube = unit_cube(sample.method, sample.count, len(sample.over), sample.seed)
        unit, index = (
            correlated(cube, [*sample.over], sample.correlation),
            np.arange(sample.count, dtype=np.int32),
        )
        columns = {
            name: Column(drawn(name, law, unit[:, axis], f"{path}.sample.over.{name}"), index)
            for axis, (name, law) in enumerate(sample.over.items())
        }
        factors.append(Points(sample.count, columns))
    if block.union:
        parts = [
            sweep_points(part, nominal, f"{path}.union[{position}]")
            for position, part in enumerate(block.union)
        ]
        factors.append(one_after_the_other(parts))
    points = reduce(multiplied, factors, Points(1, {}))
    return points if block.where is None else _fulfilling(block.where, points, nominal, f"{path}.where")


def multiplied(first: Points, second: Points) -> Points:
    """All combinations of two sets of points; the second varies fastest."""
    slow = np.repeat(np.arange(first.n_point), second.n_point)
    fast = np.tile(np.arange(second.n_point), first.n_point)
    return Points(len(slow), first.at(slow).columns | second.at(fast).columns)


def one_after_the_other(parts: Sequence[Points]) -> Points:
    """The points of several blocks; a point does not set the parameters that only other blocks set."""
    columns = {}
    for name in dict.fromkeys(name for part in parts for name in part.columns):
        values: list[Any] = []
        indices = []
        for part in parts:
            column = part.columns.get(name, Column((), np.full(part.n_point, NOMINAL, dtype=np.int32)))
            indices.append(np.where(column.index == NOMINAL, NOMINAL, column.index + np.int32(len(values))))
            values += column.values
        columns[name] = Column(values, np.concatenate(indices, dtype=np.int32))
    return Points(sum(part.n_point for part in parts), columns)


def _fulfilling(text: str, points: Points, nominal: Callable[[str], Any], path: str) -> Points:
    condition = parse_condition(text)
    constants = {name: nominal(name) for name in condition.names}
    names = [name for name in condition.names if name in points.columns]
    first, inverse = distinct_rows([points.columns[name].index for name in names], points.n_point)
    try:
        holds = [condition.holds(constants | points.values(point, names)) for point in first.tolist()]
    except (TypeError, ValueError, OverflowError) as error:
        raise ConfigError([Issue(f"condition {text!r}: {error}", path)]) from None
    return points.at(np.flatnonzero(np.array(holds, dtype=bool)[inverse]))


def drawn(name: str, distribution: dict[Any, list[Any]], unit: NDArray[np.float64], path: str) -> list[Any]:
    """Values of a parameter at probabilities."""
    values = quantiles(distribution, unit)
    is_quantity = parameter_quantity(name) is not None and "choice" not in distribution
    ends = (min(values), max(values)) if is_quantity else values  # valid quantities form an interval
    for value in ends:
        try:
            validate_parameter(name, value)
        except ValidationError as error:
            remedy = "; truncated_normal: [mean, deviation, low, high] stays within limits"
            reason = f"draws an invalid value: {first_reason(error)}"
            raise ConfigError(
                [Issue(reason + (remedy if is_unbounded(distribution) else ""), path)]
            ) from None
    return values
