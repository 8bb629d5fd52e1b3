"""Quantities with units at the border, SI floats inside.

``"551 MPa"``, ``"0.12 L/min"`` and ``"22 µm/V"`` become floats in SI. All conversion factors are
exact fractions, so that every spelling of one quantity gives the same float.
"""

from hydrofdi.units.expressions import parse_unit
from hydrofdi.units.quantities import Quantity, convert, parse_quantity, parse_si, stated_unit
from hydrofdi.units.spellings import similar_units
from hydrofdi.units.symbols import BASE_UNITS, Unit

__all__ = [
    "BASE_UNITS",
    "Quantity",
    "Unit",
    "convert",
    "parse_quantity",
    "parse_si",
    "parse_unit",
    "similar_units",
    "stated_unit",
]
