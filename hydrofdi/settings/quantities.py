"""The kind of number that a configuration holds, and the base of every section."""

from __future__ import annotations

import ast
import inspect
import json
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from hydrofdi.settings.messages import convert, out_of_range, written_units
from hydrofdi.units import given_unit, parse_quantity, parse_unit

_BARE = re.compile(r"\s*[-+]?[\d_.]+([eE][-+]?\d+)?\s*")
"""A number without a unit."""

ABOVE, BELOW = 1.0 + 1e-9, 1.0 - 1e-9
"""Factors of a limit that a computed value may equal: far wider than rounding, far narrower than a digit."""

SUPPLY_PRESSURE = ("0.1 MPa", "150 MPa")
RETURN_PRESSURE = ("1 kPa", "20 MPa")
POSITION = ("1 µm", "10 m")
SPOOL_POSITION = ("1 µm", "50 mm")
VOLTAGE = ("10 mV", "1 kV")
"""Usual lowest and highest values, far apart."""

_TEXT = json.JSONEncoder(sort_keys=True, separators=(",", ":"))


class Quantity(float):
    """A number in SI that knows its unit; ``""`` if it has none."""

    unit = ""

    @classmethod
    def of(cls, value: float, unit: str) -> Quantity:
        """A number in an SI unit."""
        quantity = cls(value)
        quantity.unit = unit
        return quantity

    def to(self, unit: str) -> float:
        """The number in another unit, e.g. ``"L/min"``."""
        if given_unit(unit, self.unit).exponents != parse_unit(self.unit or "1").exponents:
            raise ValueError(f"{unit} has the wrong dimension; it must be convertible to {self.unit or 1}")
        return convert(self, unit)


class Section(BaseModel):
    """A strict, frozen part of a configuration."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    short_forms: ClassVar[tuple[dict[str, Any], ...]] = ()
    """JSON Schemas of what may stand in the place of the section."""

    @cached_property
    def stated_text(self) -> str:
        """What differs from the defaults, as JSON; keys sorted, floats in their shortest exact form."""
        return _TEXT.encode(self.stated())

    def stated(self) -> dict[str, Any]:
        """The fields that differ from their defaults."""
        return self.model_dump(exclude_defaults=True)

    @property
    def is_default(self) -> bool:
        """Whether all fields have their defaults."""
        return self.stated_text == "{}"


@dataclass(frozen=True)
class SI:
    """Annotation of a finite quantity in an SI unit: ``Annotated[float, SI("Pa", above=0)]``.

    Numbers are taken as they are, strings are parsed with their unit.

    Attributes
    ----------
    above, least, most : float, optional
        Limits of what is allowed, in the unit.
    usual : tuple of (str, str), optional
        Generous limits of usual values; a nonzero size beyond them is probably a slip.
    symbols : str
        Symbols in equations and papers, with spaces between; exactly as written, because K_v and k_v differ.
    """

    unit: str
    above: float | None = None
    least: float | None = None
    most: float | None = None
    usual: tuple[str, str] | None = None
    symbols: str = ""

    @cached_property
    def usual_range(self) -> tuple[float, float]:
        """Lowest and highest usual size, in the unit; any is usual if none are stated."""
        low, high = (parse_quantity(bound, self.unit) for bound in self.usual or ("0", "1e300"))
        return low, high

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Parse and check the limits, then refuse what is not finite."""
        number = core_schema.float_schema(allow_inf_nan=False)
        return core_schema.no_info_before_validator_function(self.parse, number)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """A number in SI or a string with a unit."""
        return {"anyOf": [{"type": "number"}, {"type": "string"}], "unit": self.unit}

    def parse(self, value: Any) -> float:
        """The value in `unit`."""
        number = self._number(value)
        if self.above is not None and number <= self.above:
            raise ValueError(out_of_range("greater than", self.above, value, self.unit))
        if self.least is not None and number < self.least:
            raise ValueError(out_of_range("at least", self.least, value, self.unit))
        if self.most is not None and number > self.most:
            raise ValueError(out_of_range("at most", self.most, value, self.unit))
        return number

    def _number(self, value: Any) -> float:
        if isinstance(value, str):
            if self.unit != "1" and _BARE.fullmatch(value):
                readings = [f"{value.strip()} {unit}" for unit in written_units(self.unit)]
                meant = " or ".join(map(repr, filter(self._is_usual, readings))) or repr(readings[0])
                raise ValueError(f"{value!r} has no unit; write {meant}")
            return parse_quantity(value, self.unit)
        if isinstance(value, bool) or not isinstance(value, int | float):
            unit = "" if self.unit == "1" else f" in {self.unit}, or a string with a unit"
            raise ValueError(f"expected a number{unit}")
        return float(value)

    def _is_usual(self, text: str) -> bool:
        """Whether a quantity is allowed, and of a usual size."""
        low, high = self.usual_range
        try:
            return low <= abs(self.parse(text)) <= high
        except ValueError:
            return False


def field_quantity(field: FieldInfo) -> SI | None:
    """Quantity of a field, also where it stands in a union, a tuple or a list; None if it has none."""
    return next(
        (part for part in (*field.metadata, *_nested(field.annotation)) if isinstance(part, SI)), None
    )


def _nested(annotation: Any) -> Iterator[Any]:
    for part in getattr(annotation, "__args__", ()):
        yield from (*getattr(part, "__metadata__", ()), *_nested(part))


def field_texts(model: type[BaseModel]) -> dict[str, str]:
    """Field → its docstring, those of the bases included; read from the source, when it is needed."""
    texts = {}
    for base in reversed(model.__mro__):
        if not issubclass(base, BaseModel) or base is BaseModel:
            continue
        for field, text in pairwise(_definitions(base.__module__)[base.__name__].body):
            match field, text:
                case ast.AnnAssign(target=ast.Name(name)), ast.Expr(value=ast.Constant(value=str(words))):
                    texts[name] = inspect.cleandoc(words)
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _definitions(module: str) -> dict[str, ast.ClassDef]:
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
