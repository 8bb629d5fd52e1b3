"""Options of an indicator that describe the plant, and those of them left at their defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hydrofdi.settings.quantities import SI, Section


@dataclass(frozen=True)
class PlantConstant:
    """Annotation of an option that describes the plant.

    Attributes
    ----------
    option : str
        The constant is used only if this option has one of the `values`; always if empty.
    values : tuple
    """

    option: str = ""
    values: tuple[Any, ...] = ()

    def is_used(self, options: Section) -> bool:
        """Whether the indicator uses the constant with these options."""
        return not self.option or getattr(options, self.option, None) in self.values


def plant_constants(options: Section) -> dict[str, str]:
    """Plant constant used with these options → its SI unit."""
    found = {}
    for name, info in type(options).model_fields.items():
        marks = [each for each in info.metadata if isinstance(each, PlantConstant)]
        if any(mark.is_used(options) for mark in marks):
            found[name] = next((each.unit for each in info.metadata if isinstance(each, SI)), "1")
    return found


def constants_not_given(options: Section) -> tuple[str, ...]:
    """Plant constants that are used but were left at their defaults."""
    return tuple(name for name in plant_constants(options) if name not in options.model_fields_set)
