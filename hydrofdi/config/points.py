"""A sweep block → its points."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config.condition import parse_condition
from hydrofdi.config.parameters import validate_parameter
from hydrofdi.config.sweep import SampleConfig, SweepConfig

Point = dict[str, Any]
"""Dotted parameter → its value in SI."""


def sweep_points(block: SweepConfig, nominal: Callable[[str], Any]) -> list[Point]:
    """The points of a block in their order.

    Parameters
    ----------
    block : SweepConfig
    nominal : callable
        Gives the value of a parameter that does not vary, for conditions.

    Raises
    ------
    pydantic.ValidationError
        A sampled value is not one that its parameter can take.
    """
    factors: list[list[Point]] = []
    if block.grid:
        factors.append(
            [dict(zip(block.grid, values, strict=True)) for values in product(*block.grid.values())]
        )
    if block.zip:
        factors.append(
            [dict(zip(block.zip, values, strict=True)) for values in zip(*block.zip.values(), strict=True)]
        )
    if block.sample:
        factors.append(sample_points(block.sample))
    if block.union:
        factors.append([point for part in block.union for point in sweep_points(part, nominal)])
    points = factors[0] if len(factors) == 1 else [_merged(parts) for parts in product(*factors)]
    return points if block.where is None else _fulfilling(block.where, points, nominal)


def sample_points(sample: SampleConfig) -> list[Point]:
    """The points of a sample."""
    unit = _unit_cube(sample)
    columns = [
        _quantiles(name, distribution, unit[:, axis])
        for axis, (name, distribution) in enumerate(sample.over.items())
    ]
    return [dict(zip(sample.over, values, strict=True)) for values in zip(*columns, strict=True)]


def _merged(parts: tuple[Point, ...]) -> Point:
    merged: Point = {}
    for part in parts:
        merged |= part
    return merged


def _fulfilling(text: str, points: list[Point], nominal: Callable[[str], Any]) -> list[Point]:
    condition = parse_condition(text)
    constants = {name: nominal(name) for name in condition.names}
    return [point for point in points if condition.holds(constants | point)]


def _unit_cube(sample: SampleConfig) -> NDArray[np.float64]:
    """Points in the unit cube, shape (count, number of parameters)."""
    if sample.method == "random":
        return np.random.default_rng(sample.seed).random((sample.count, len(sample.over)))
    from scipy.stats import qmc

    sequence = qmc.Sobol if sample.method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a count that is no power of two is the user's choice
        cube: NDArray[np.float64] = sequence(len(sample.over), rng=sample.seed).random(sample.count)
    return cube


def _quantiles(name: str, distribution: Mapping[Any, list[Any]], unit: NDArray[np.float64]) -> list[Any]:
    """Values of a distribution at the given probabilities."""
    ((kind, arguments),) = distribution.items()
    if kind == "choice":
        positions = np.minimum((unit * len(arguments)).astype(int), len(arguments) - 1)
        return [arguments[position] for position in positions]
    first, second = arguments
    if kind == "uniform":
        values = first + (second - first) * unit
    elif kind == "loguniform":
        values = first * (second / first) ** unit
    else:
        from scipy.special import ndtri

        values = first + second * ndtri(np.clip(unit, 2.0**-53, 1.0 - 2.0**-53))
    return [validate_parameter(name, value) for value in values.tolist()]
