"""Distributions that parameters are drawn from: their arguments and their quantiles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

ARGUMENTS: dict[str, tuple[str, ...]] = {
    "uniform": ("low", "high"),
    "loguniform": ("low", "high"),
    "normal": ("mean", "deviation"),
    "truncated_normal": ("mean", "deviation", "low", "high"),
    "lognormal": ("median", "factor"),
    "triangular": ("low", "mode", "high"),
    "integers": ("low", "high"),
}
"""Distribution → its arguments. All are values of the parameter, except a deviation (a positive difference of
two values) and a factor (a number greater than one)."""

DISTRIBUTIONS = (*ARGUMENTS, "choice")

_UNBOUNDED = ("normal", "lognormal")

Quantiles = Callable[..., NDArray[Any]]


def argument_values(distribution: dict[Any, list[Any]]) -> list[Any]:
    """The arguments of a distribution that are values of its parameter."""
    ((kind, arguments),) = distribution.items()
    roles = ARGUMENTS.get(kind, ("value",) * len(arguments))
    return [
        value for role, value in zip(roles, arguments, strict=True) if role not in ("deviation", "factor")
    ]


def is_unbounded(distribution: dict[Any, list[Any]]) -> bool:
    """Whether a distribution has an unbounded tail."""
    return any(kind in _UNBOUNDED for kind in distribution)


def require_order(kind: str, arguments: Sequence[float]) -> None:
    """Check the arguments of a distribution: their order, and that deviation and factor are large enough.

    Raises
    ------
    ValueError
        Their order is wrong, or the deviation or the factor is too small.
    """
    named = dict(zip(ARGUMENTS[kind], arguments, strict=True))
    if "deviation" in named and not named["deviation"] > 0.0:
        raise ValueError(f"the standard deviation must be greater than 0; found {named['deviation']:g}")
    if "factor" in named and not named["factor"] > 1.0:
        raise ValueError(
            f"the factor (geometric standard deviation) must be greater than 1; found {named['factor']:g}"
        )
    if "low" not in named:
        return
    if kind == "integers":
        if named["low"] > named["high"]:
            raise ValueError("needs low ≤ high")
        return
    if not named["low"] < named["high"] or (kind == "loguniform" and named["low"] <= 0.0):
        raise ValueError(f"needs low < high{', both above zero' if kind == 'loguniform' else ''}")
    if "mode" in named and not named["low"] <= named["mode"] <= named["high"]:
        raise ValueError("needs low ≤ mode ≤ high")


def quantiles(distribution: dict[Any, list[Any]], unit: NDArray[np.float64]) -> list[Any]:
    """Values of a distribution at probabilities, shape (n_point,)."""
    ((kind, arguments),) = distribution.items()
    if kind == "choice":
        positions = np.minimum((unit * len(arguments)).astype(int), len(arguments) - 1)
        return [arguments[position] for position in positions]
    inside = np.clip(unit, 2.0**-53, 1.0 - 2.0**-53)
    return _QUANTILES[kind](inside if is_unbounded(distribution) else unit, *arguments).tolist()  # type: ignore[no-any-return]


def _uniform(unit: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    return low + (high - low) * unit


def _integers(unit: NDArray[np.float64], low: int, high: int) -> NDArray[np.int64]:
    return low + np.minimum((unit * (high - low + 1)).astype(np.int64), high - low)


def _loguniform(unit: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    return low * (high / low) ** unit


def _normal(unit: NDArray[np.float64], mean: float, deviation: float) -> NDArray[np.float64]:
    from scipy.special import ndtri

    values: NDArray[np.float64] = mean + deviation * ndtri(unit)
    return values


def _lognormal(unit: NDArray[np.float64], median: float, factor: float) -> NDArray[np.float64]:
    return median * np.exp(_normal(unit, 0.0, math.log(factor)))


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


_QUANTILES: dict[str, Quantiles] = {
    "uniform": _uniform,
    "loguniform": _loguniform,
    "normal": _normal,
    "truncated_normal": _truncated_normal,
    "lognormal": _lognormal,
    "triangular": _triangular,
    "integers": _integers,
}
