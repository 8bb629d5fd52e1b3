"""Values of parameters: the distributions that they are drawn from, and how a person reads them.

People read them in units that suit them, with four digits; integers in full.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError, WithJsonSchema

from hydrofdi.config.drive import without_contents
from hydrofdi.config.request import (
    RunParameters,
    parameter_names,
    parameter_quantity,
    parameter_unit,
    validate_parameter,
)
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import (
    convert,
    first_reason,
    number_text,
    readable_unit,
    shown_quantity,
    typeset,
)
from hydrofdi.settings.quantities import Section, field_quantity
from hydrofdi.tables.answer import Answer, Piece
from hydrofdi.tables.table import TEXT_WIDTH, Column

Quantiles = Callable[..., NDArray[Any]]


def argument_values(stated: Any) -> list[Any]:
    """The values of a parameter that are stated: one, those of an axis, or arguments of a distribution."""
    if not isinstance(stated, Mapping):
        return stated if isinstance(stated, list) else [stated]
    ((kind, arguments),) = stated.items()
    roles = LAWS[kind].arguments if kind in LAWS else ("value",) * len(arguments)
    return [
        value for role, value in zip(roles, arguments, strict=False) if role not in ("deviation", "factor")
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
    """A distribution; its arguments are values of the parameter, except a deviation and a factor."""

    arguments: tuple[str, ...]
    shown: str
    quantiles: Quantiles


LAWS = {
    "uniform": Law(("low", "high"), "{} … {} {unit}", lambda unit, low, high: low + (high - low) * unit),
    "loguniform": Law(
        ("low", "high"), "{} … {} {unit} (logarithmic)", lambda unit, low, high: low * (high / low) ** unit
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


Kind = Literal[
    "uniform", "loguniform", "normal", "truncated_normal", "lognormal", "triangular", "integers", "choice"
]

_ARGUMENTS = {"anyOf": [{"type": "array", "items": {}}, {"type": "string", "pattern": "^\\s*(±|\\+/-|\\+-)"}]}

Distribution = dict[Kind, Annotated[list[Any], WithJsonSchema(_ARGUMENTS)]]
"""Name of a distribution → its arguments, in SI."""


def require_law(name: str, kind: str, values: list[Any]) -> None:
    """Check that the arguments of a law are of the parameter's kind, in the right order, and large enough."""
    named = dict(zip(LAWS[kind].arguments, values, strict=True))
    if isinstance(values[0], int) != (kind == "integers"):
        other = "uniform" if kind == "integers" else "integers"
        raise ValueError(f"does not fit {name}; draw it with {{{other}: [low, high]}}")
    for role, least in (("deviation", 0.0), ("factor", 1.0)):
        if not named.get(role, math.inf) > least:
            raise ValueError(f"the {role} must be greater than {least:g}; found {named[role]:g}")
    order = [role for role in ("low", "mode", "high") if role in named]
    ends = [named[role] for role in order]
    if ends and (ends != sorted(ends) or (ends[0] == ends[-1] and kind != "integers")):
        raise ValueError(f"needs {' ≤ '.join(order)}")
    if kind == "loguniform" and ends[0] <= 0.0:
        raise ValueError("needs ends above zero")


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


_UNITS: ContextVar[Mapping[str, str]] = ContextVar("units of the reader", default=MappingProxyType({}))
"""Dotted name → unit in which the reader writes it."""


@contextmanager
def shown_in(units: Mapping[str, str]) -> Iterator[None]:
    """Show parameters in these units (dotted name → unit), and all others in units that suit their size."""
    token = _UNITS.set(units)
    try:
        yield
    finally:
        _UNITS.reset(token)


@dataclass(frozen=True)
class ShownParameter:
    """How a person reads the values of a parameter: its SI unit and the unit in which they are shown."""

    name: str
    own_unit: str
    unit: str

    @property
    def header(self) -> str:
        """Name and unit, such as ``fluid.bulk_modulus [MPa]``."""
        return f"{self.name} [{typeset(self.unit)}]" if self.unit not in ("", "1") else self.name

    def number(self, value: float) -> float:
        """A value in SI in the unit in which it is shown."""
        return convert(value, self.unit, self.own_unit)

    def text(self, value: Any) -> str:
        """A value in SI without its unit, such as ``689``."""
        if is_number(value) and (isinstance(value, float) or self.unit != self.own_unit):
            return number_text(self.number(value))
        return str(without_contents(value))


def shown_parameter(name: str, values: Iterable[Any]) -> ShownParameter:
    """A parameter in the unit of the reader (`shown_in`), else in one that suits its largest value [SI]."""
    own = (parameter_unit(name) if name in parameter_names() else None) or ""
    if own and (unit := _UNITS.get().get(name)):
        return ShownParameter(name, own, unit)
    numbers = [abs(value) for value in values if is_number(value)]
    return ShownParameter(name, own, readable_unit(own, max(numbers)) if numbers else own)


def shown_modulus() -> ShownParameter:
    """How people read the EBM: in MPa where the experiment is not written in another unit."""
    return shown_parameter("fluid.bulk_modulus", [1e9])


def modulus_column(bulk_moduli: Any) -> Column:
    """A column of EBM."""
    shown = shown_modulus()
    return Column("bulk_modulus", bulk_moduli, "Pa", f"EBM [{shown.unit}]", shown.text)


def shown_values(values: Mapping[str, Any]) -> str:
    """Values of dotted parameters: ``valve.lap = 50 µm, fluid.law = free_air``."""
    return ", ".join(f"{name} = {shown_value(name, value)}" for name, value in values.items())


def shown_options(options: Section) -> str:
    """What a section states, without its defaults: ``bulk_modulus 1000 MPa, levels 3``."""
    fields, texts = type(options).model_fields, []
    for name, value in options.stated().items():
        quantity = field_quantity(fields[name]) if name in fields and is_number(value) else None
        texts.append(f"{name} {value if quantity is None else shown_quantity(value, quantity.unit)}")
    return ", ".join(texts)


def shown_value(name: str, value: Any) -> str:
    """A value of a dotted parameter with its unit, such as ``689 MPa``, or its distribution."""
    kind, arguments = next(iter(value.items())) if isinstance(value, dict) and value else ("", [value])
    if not isinstance(arguments, list | tuple):
        return str(without_contents(value))
    n_own = 1 if kind == "lognormal" else len(arguments)
    parameter = shown_parameter(name, arguments[:n_own])
    texts = [parameter.text(argument) for argument in arguments[:n_own]]
    texts += [number_text(argument) for argument in arguments[n_own:]]
    written = LAWS[kind].shown if kind in LAWS else ""
    if not written or len(texts) != written.count("{}"):
        written = f"{' or '.join(texts)} {{unit}}"
    unit = typeset(parameter.unit) if any(map(is_number, arguments)) and parameter.unit != "1" else ""
    return " ".join(written.format(*texts, unit=unit).split()).replace(" ,", ",")


def varied_parameters(runs: Iterable[RunParameters]) -> list[str]:
    """The dotted parameters that are not the same in all runs."""
    first, *others = list(dict.fromkeys(runs))
    return [
        name
        for name in parameter_names(type(first))
        if any(other.value(name) != first.value(name) for other in others)
    ]


def is_number(value: Any) -> bool:
    """Whether a value is a number, not true or false."""
    return isinstance(value, int | float) and not isinstance(value, bool)


class ParameterAnswer(Answer):
    """An answer with parameters, which people read in the units in which the experiment writes them."""

    units: Mapping[str, str]

    def lines(self, width: int = TEXT_WIDTH) -> Iterator[tuple[Piece, list[tuple[str, str]]]]:
        """The parts that people read, each with its lines and their style."""
        with shown_in(self.units):
            yield from super().lines(width)

    def value_text(self, name: str, value: Any) -> str | None:
        """A value of a parameter with its unit."""
        parameter = name.rpartition(": ")[2]
        return shown_value(parameter, value) if parameter in parameter_names() else None
