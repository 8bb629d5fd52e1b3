"""Distributions: how experiment files state them, and their quantiles."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hydrofdi.config.request import parameter_names, parameter_unit, validate_parameter
from hydrofdi.config.sweeps.values import (
    difference,
    is_stated,
    nominal_value,
    parameter_value,
    require_numbers,
)
from hydrofdi.settings.messages import describe_error, nearest
from hydrofdi.settings.yaml_source import Path, Source
from hydrofdi.units import parse_quantity

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


def require_order(kind: str, arguments: Sequence[float]) -> None:
    """Check the arguments of a distribution: their order, and that deviation and factor are large enough.

    Raises
    ------
    ValueError
        Their order is wrong, or the deviation or the factor is too small.
    """
    named = dict(zip(LAWS[kind].arguments, arguments, strict=True))
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

DISTRIBUTIONS = (*LAWS, "choice")

_ABOUT = re.compile(r"\s*(?:±|\+/-|\+-)\s*(.*)", re.DOTALL)
"""A width about the nominal value, such as ``±20 %`` or ``±1 µm``."""

_NUMBER = re.compile(r"[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*")

_ARGUMENTS_ABOUT = {
    "uniform": lambda nominal, width: [nominal - width, nominal + width],
    "triangular": lambda nominal, width: [nominal - width, nominal, nominal + width],
    "normal": lambda nominal, width: [nominal, width],
}
"""Distribution → its arguments from the nominal value and the width after ``±``."""


def distribution_in_si(source: Source, path: Path, name: str, distribution: Any) -> Any:
    """A distribution with its arguments in SI; if invalid, an empty one, and the source gets a mistake."""
    try:
        return _in_si(source, path, name, distribution)
    except _MistakenError as mistake:
        source.report(mistake.path, str(mistake))
        return {DISTRIBUTIONS[0]: []}  # validation of the model does not report it again


class _MistakenError(ValueError):
    def __init__(self, path: Path, message: str) -> None:
        super().__init__(message)
        self.path = path


def _in_si(source: Source, path: Path, name: str, distribution: Any) -> Any:
    if not isinstance(distribution, dict) or len(distribution) != 1:
        raise _MistakenError(
            path, f"expected one of {', '.join(DISTRIBUTIONS)}, e.g. {{uniform: [low, high]}}"
        )
    ((kind, arguments),) = distribution.items()
    path = (*path, kind)
    if kind not in DISTRIBUTIONS:
        raise _MistakenError(path, f"unknown distribution{nearest(kind, DISTRIBUTIONS)}")
    if isinstance(arguments, str) and (about := _ABOUT.fullmatch(arguments)):
        return {kind: _about_nominal(source, path, name, kind, about[1])}
    roles = LAWS[kind].arguments if kind in LAWS else None
    if not isinstance(arguments, list) or not arguments or (roles and len(arguments) != len(roles)):
        wanted = f"[{', '.join(roles)}]" if roles else "a list of values"
        raise _MistakenError(path, f"expected {wanted}; found {arguments!r}")
    values = [
        _argument(source, (*path, index), name, role, argument)
        for index, (role, argument) in enumerate(zip(roles or [""] * len(arguments), arguments, strict=True))
    ]
    if roles:
        _require_kind(source, path, name, kind, values)
    return {kind: values}


def _about_nominal(source: Source, path: Path, name: str, kind: str, width: str) -> list[float]:
    """The arguments of a distribution about the nominal value of its parameter."""
    if kind not in _ARGUMENTS_ABOUT:
        raise _MistakenError(path, f"± is only for {', '.join(_ARGUMENTS_ABOUT)}; {kind} needs its arguments")
    if name not in parameter_names():
        parameter_value(source, path, name, None)
        return []
    nominal = nominal_value(source, name)
    if nominal is None and is_stated(source, name):  # validation of the model reports it
        return []
    if isinstance(nominal, bool) or not isinstance(nominal, float):
        raise _MistakenError(
            path, f"± needs a nominal value, and {name} has none that is a real number; state the arguments"
        )
    unit = parameter_unit(name)
    if unit not in (None, "1") and _NUMBER.fullmatch(width):
        raise _MistakenError(path, f"±{width} has no unit; write ±{width} % or ±{width} {unit}")
    try:
        is_share = width.endswith("%")
        size = abs(nominal) * parse_quantity(width, "1") if is_share else difference(name, width)
    except ValueError as error:
        raise _MistakenError(path, str(error)) from None
    if is_share and nominal == 0.0:
        raise _MistakenError(path, f"±{width} of {name} = 0 is 0; write ± and a quantity instead")
    if not math.isfinite(size):
        raise _MistakenError(path, f"the width after ± must be finite; found {width}")
    if not size > 0.0:
        raise _MistakenError(path, f"the width after ± must be greater than 0; found {width}")
    arguments = _ARGUMENTS_ABOUT[kind](nominal, size)
    try:
        for value in argument_values({kind: arguments}):
            validate_parameter(name, value)
    except ValidationError as error:
        reason = describe_error(error.errors()[0])
        raise _MistakenError(path, f"±{width} reaches an invalid value: {reason}") from None
    return arguments


def _argument(source: Source, path: Path, name: str, role: str, argument: Any) -> Any:
    """An argument of a distribution in SI."""
    if role not in ("deviation", "factor"):
        return parameter_value(source, path, name, argument)
    try:
        return difference(name if role == "deviation" else "", argument)
    except ValueError as error:
        raise _MistakenError(path, str(error)) from None


def _require_kind(source: Source, path: Path, name: str, kind: str, values: list[Any]) -> None:
    """Check that the arguments are numbers of the parameter's kind, in the right order."""
    are_whole = all(isinstance(value, int) and not isinstance(value, bool) for value in values)
    are_numbers = all(isinstance(value, float) for value in values)
    if are_whole and kind != "integers":
        raise _MistakenError(path, f"{name} is an integer; draw it with {{integers: [low, high]}}")
    if are_numbers and kind == "integers":
        raise _MistakenError(path, f"{name} is not an integer; draw it with {{uniform: [low, high]}}")
    if not (are_numbers or are_whole):
        require_numbers(source, path)
        return
    try:
        require_order(kind, values)
    except ValueError as error:
        raise _MistakenError(path, str(error)) from None
