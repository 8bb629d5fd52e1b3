"""Which options of an indicator describe the plant, and which of them nobody gave."""

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
        The constant is used only where this option has one of the `values`; always where it is empty.
    values : tuple
    """

    option: str = ""
    values: tuple[Any, ...] = ()

    def is_used(self, options: Section) -> bool:
        """Whether the indicator uses it under some options."""
        return not self.option or getattr(options, self.option, None) in self.values


def plant_constants(options: Section) -> dict[str, str]:
    """The constants of the plant that are used under some options → their SI units."""
    found = {}
    for name, info in type(options).model_fields.items():
        marks = [each for each in info.metadata if isinstance(each, PlantConstant)]
        if any(mark.is_used(options) for mark in marks):
            found[name] = next((each.unit for each in info.metadata if isinstance(each, SI)), "1")
    return found


def constants_not_given(options: Section) -> tuple[str, ...]:
    """The constants of the plant that are used with their defaults because nobody gave them."""
    return tuple(name for name in plant_constants(options) if name not in options.model_fields_set)
