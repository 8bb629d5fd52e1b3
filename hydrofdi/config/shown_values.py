"""Values as a person reads them: in units that suit them, with four digits; integers in full."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from hydrofdi.config.drive import without_contents
from hydrofdi.config.request import RunParameters, parameter_names, parameter_unit
from hydrofdi.config.sweep import LAWS
from hydrofdi.settings.messages import number_text, readable_unit, shown_quantity, typeset
from hydrofdi.settings.quantities import Section, field_quantity
from hydrofdi.tables.answer import Answer, Piece
from hydrofdi.tables.table import TEXT_WIDTH, Column
from hydrofdi.units import convert

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
        return convert(value, self.unit) if self.unit != self.own_unit else value

    def text(self, value: Any) -> str:
        """A value in SI without its unit, such as ``689``."""
        if _is_number(value) and (isinstance(value, float) or self.unit != self.own_unit):
            return number_text(self.number(value))
        return str(without_contents(value))


def shown_parameter(name: str, values: Iterable[Any]) -> ShownParameter:
    """A parameter in the unit of the reader (`shown_in`), else in one that suits its largest value [SI]."""
    own = (parameter_unit(name) if name in parameter_names() else None) or ""
    if own and (unit := _UNITS.get().get(name)):
        return ShownParameter(name, own, unit)
    numbers = [abs(value) for value in values if _is_number(value)]
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
        quantity = field_quantity(fields[name]) if name in fields and _is_number(value) else None
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
    unit = typeset(parameter.unit) if any(map(_is_number, arguments)) and parameter.unit != "1" else ""
    return " ".join(written.format(*texts, unit=unit).split()).replace(" ,", ",")


def varied_parameters(runs: Iterable[RunParameters]) -> list[str]:
    """The dotted parameters that are not the same in all runs."""
    first, *others = list(dict.fromkeys(runs))
    return [
        name
        for name in parameter_names(type(first))
        if any(other.value(name) != first.value(name) for other in others)
    ]


def _is_number(value: Any) -> bool:
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
