"""The ``sweep`` section: which parameters vary, and how.

Blocks beside each other are combined, the points of a union are concatenated, and blocks nest.
"""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from hydrofdi.config.sweeps.condition import parse_condition
from hydrofdi.config.sweeps.sample import SampleConfig
from hydrofdi.settings.quantities import Section

_VALUE = {"anyOf": [{"type": "number"}, {"type": "string"}, {"type": "boolean"}]}


def _generator(name: str, third: str) -> dict[str, Any]:
    items = {"type": "array", "prefixItems": [_VALUE, _VALUE, _VALUE], "minItems": 3, "maxItems": 3}
    return {
        "type": "object",
        "properties": {name: items | {"description": f"[first, last, {third}]"}},
        "required": [name],
        "additionalProperties": False,
    }


_AXIS = {
    "anyOf": [
        {"type": "array", "items": _VALUE, "minItems": 1},
        _generator("linspace", "count"),
        _generator("logspace", "count"),
        _generator("arange", "step"),
    ]
}
_AXES = {"type": "object", "additionalProperties": _AXIS}

Axes = Annotated[dict[str, list[Any]], WithJsonSchema(_AXES)]
"""Dotted parameter → its values in SI; generators are expanded when a file is loaded."""


def _parsed(text: Any) -> Any:
    if isinstance(text, str):
        parse_condition(text)
    return text


class SweepConfig(Section):
    """A block of a sweep."""

    grid: Axes = Field(default_factory=dict)
    """All combinations of the values of several parameters; the last one varies fastest."""

    zip: Axes = Field(default_factory=dict)
    """Parameters that vary together; all lists have the same length."""

    sample: SampleConfig | None = None
    """Points drawn from distributions."""

    union: list[SweepConfig] = Field(default_factory=list)
    """Blocks whose points are concatenated."""

    where: Annotated[str, BeforeValidator(_parsed)] | None = None
    """Condition that the points of the block must satisfy, such as ``friction.breakaway >=
    friction.coulomb``. Quantities are quoted: ``fluid.bulk_modulus > '600 MPa'``."""

    @model_validator(mode="after")
    def _zipped_lists_have_one_length(self) -> Self:
        lengths = {name: len(values) for name, values in self.zip.items()}
        if len(set(lengths.values())) > 1:
            lengths_shown = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            raise ValueError(f"zip needs lists of the same length: {lengths_shown}")
        return self

    @model_validator(mode="after")
    def _each_parameter_varies_once(self) -> Self:
        seen: set[str] = set()
        for names in self._groups():
            if twice := seen & names:
                raise ValueError(f"{sorted(twice)[0]} varies in two blocks that multiply")
            seen |= names
        return self

    def _groups(self) -> list[set[str]]:
        over = set(self.sample.over) if self.sample else set[str]()
        in_union = {name for block in self.union for name in block.names}
        return [set(self.grid), set(self.zip), over, in_union]

    @property
    def names_throughout(self) -> set[str]:
        """Parameters that vary in every point of the block, so that their nominal values are not used."""
        return {*self.grid, *self.zip, *(self.sample.over if self.sample else ())}

    @property
    def names(self) -> list[str]:
        """All parameters that vary in the block, in the order of the file."""
        over = self.sample.over if self.sample else {}
        in_union = [name for block in self.union for name in block.names]
        return list(dict.fromkeys([*self.grid, *self.zip, *over, *in_union]))
