"""Distributions and their quantiles."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Quantiles = Callable[..., NDArray[Any]]


def argument_values(distribution: dict[Any, list[Any]]) -> list[Any]:
    """The arguments of a distribution that are values of its parameter."""
    ((kind, arguments),) = distribution.items()
    roles = LAWS[kind].arguments if kind in LAWS else ("value",) * len(arguments)
    return [
        value for role, value in zip(roles, arguments, strict=True) if role not in ("deviation", "factor")
    ]


def is_unbounded(distribution: dict[Any, list[Any]]) -> bool:
    """Whether a distribution has an unbounded tail."""
    return any(kind in ("normal", "lognormal") for kind in distribution)


def quantiles(distribution: dict[Any, list[Any]], unit: NDArray[np.float64]) -> list[Any]:
    """Values of a distribution at probabilities, shape (n_point,)."""
    ((kind, arguments),) = distribution.items()
    if kind == "choice":
        positions = np.minimum((unit * len(arguments)).astype(int), len(arguments) - 1)
        return [arguments[position] for position in positions]
    inside = np.clip(unit, 2.0**-53, 1.0 - 2.0**-53)
    return LAWS[kind].quantiles(inside if is_unbounded(distribution) else unit, *arguments).tolist()  # type: ignore[no-any-return]


def _normal(unit: NDArray[np.float64], mean: float, deviation: float) -> NDArray[np.float64]:
    from scipy.special import ndtri

    values: NDArray[np.float64] = mean + deviation * ndtri(unit)
    return values


def _truncated_normal(
    unit: NDArray[np.float64], mean: float, deviation: float, low: float, high: float
) -> NDArray[np.float64]:
    from scipy.stats import truncnorm

    limits = (low - mean) / deviation, (high - mean) / deviation
    return np.clip(truncnorm.ppf(unit, *limits, loc=mean, scale=deviation), low, high)


def _triangular(unit: NDArray[np.float64], low: float, mode: float, high: float) -> NDArray[np.float64]:
    from scipy.stats import triang

    width = high - low
    return np.clip(triang.ppf(unit, (mode - low) / width, loc=low, scale=width), low, high)


class Law(NamedTuple):
    """A distribution.

    Its arguments are values of the parameter, except a deviation (a positive difference of two values) and a
    factor (a number greater than one).
    """

    arguments: tuple[str, ...]
    shown: str
    quantiles: Quantiles


LAWS = {
    "uniform": Law(("low", "high"), "{} … {} {unit}", lambda unit, low, high: low + (high - low) * unit),
    "loguniform": Law(
        ("low", "high"),
        "{} … {} {unit} (logarithmic)",
        lambda unit, low, high: low * (high / low) ** unit,
    ),
    "normal": Law(("mean", "deviation"), "{} ± {} {unit} (normal)", _normal),
    "truncated_normal": Law(
        ("mean", "deviation", "low", "high"),
        "{} ± {} {unit} (normal), from {} to {} {unit}",
        _truncated_normal,
    ),
    "lognormal": Law(
        ("median", "factor"),
        "{} {unit}, factor {} (lognormal)",
        lambda unit, median, factor: median * np.exp(_normal(unit, 0.0, math.log(factor))),
    ),
    "triangular": Law(("low", "mode", "high"), "{} … {} … {} {unit} (triangular)", _triangular),
    "integers": Law(
        ("low", "high"),
        "{} … {} {unit}",
        lambda unit, low, high: low + np.minimum((unit * (high - low + 1)).astype(np.int64), high - low),
    ),
}
