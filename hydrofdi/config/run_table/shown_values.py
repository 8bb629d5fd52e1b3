"""Values of dotted parameters for people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from hydrofdi.config.parameters import RunParameters
from hydrofdi.config.request import parameter_names, parameter_unit
from hydrofdi.config.sections.csv_input import without_contents


def shown_values(values: Mapping[str, Any]) -> str:
    """Values of dotted parameters in SI, for people: ``valve.lap = 5e-05 m, fluid.law = free_air``."""
    return ", ".join(f"{name} = {shown_value(name, value)}" for name, value in values.items())


def shown_value(name: str, value: Any) -> str:
    """A value of a dotted parameter in SI, for people."""
    unit = parameter_unit(name)
    if not isinstance(value, float) or unit is None:
        return str(without_contents(value))
    return f"{value:g}" if unit == "1" else f"{value:g} {unit.replace('*', '·')}"


def varied_parameters(runs: Iterable[RunParameters]) -> list[str]:
    """The dotted parameters that are not the same in all runs."""
    first, *others = list(dict.fromkeys(runs))
    return [
        name
        for name in parameter_names(type(first))
        if any(other.value(name) != first.value(name) for other in others)
    ]
