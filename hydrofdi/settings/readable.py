"""Units that a person reads numbers in SI in."""

from __future__ import annotations

_READABLE = {
    "Pa": (("MPa", 1e6), ("kPa", 1e3)),
    "m^3/s": (("L/min", 0.0),),
    "m³/s": (("L/min", 0.0),),
    "m": (("m", 1.0), ("mm", 1e-4), ("µm", 0.0)),
    "m/s": (("m/s", 1.0), ("mm/s", 0.0)),
    "m^2": (("mm^2", 0.0),),
    "m^3": (("cm^3", 0.0),),
    "s": (("s", 0.1), ("ms", 0.0)),
    "N": (("kN", 1e4),),
    "N/m": (("kN/m", 1e4),),
    "m/V": (("µm/V", 0.0),),
}
"""SI unit → units that a person reads, and from which size on."""


def readable_unit(own: str, largest: float) -> str:
    """The unit in which a person reads numbers up to `largest` [in `own`, SI]; `own` where there is none."""
    units = _READABLE.get(own, ())
    if units and largest == 0.0:
        return units[-1][0]
    return next((unit for unit, least in units if largest >= least), own)
