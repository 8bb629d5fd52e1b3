"""The ``store`` section: what is kept of each run, and how."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, WithJsonSchema

from hydrofdi.settings.mistakes import nearest
from hydrofdi.settings.quantities import Section

SIGNALS = (
    "input_voltage", "reference_position", "load_force", "spool_position", "piston_position",
    "piston_velocity", "chamber_1_pressure", "chamber_2_pressure", "valve_supply_pressure",
    "internal_leakage_flow",
)  # fmt: skip
"""Signals of a run, in the order of a file."""

NAMED = {"all": SIGNALS, "pressures": ("chamber_1_pressure", "chamber_2_pressure"), "none": ()}
"""Word for some of them → their names."""


def _as_text(given: Any) -> str:
    """A choice of signals as one text: a word for them, or their names in order."""
    names = NAMED.get(given) if isinstance(given, str) else given
    names = given.split(",") if names is None else names
    if not isinstance(names, list | tuple):
        raise ValueError(f"expected {', '.join(NAMED)}, or a list of signals")
    for name in names:
        if name not in SIGNALS:
            raise ValueError(f"there is no signal {name!r}{nearest(str(name), [*SIGNALS, *NAMED])}")
    kept = tuple(name for name in SIGNALS if name in names)
    return next((word for word, meant in NAMED.items() if meant == kept), ",".join(kept))


Signals = Annotated[
    str,
    BeforeValidator(_as_text),
    WithJsonSchema({"anyOf": [{"enum": list(NAMED)}, {"type": "array", "items": {"enum": list(SIGNALS)}}]}),
]
"""Which signals: ``all``, ``pressures``, ``none``, or names with commas between them."""


class StoreConfig(Section):
    """What the experiment file holds besides the features."""

    signals: Signals = "all"
    """``all`` signals, the chamber ``pressures`` alone, ``none``, or a list of those that are kept, such as
    ``[chamber_1_pressure, spool_position]``: input_voltage, reference_position, load_force, spool_position,
    piston_position, piston_velocity, chamber_1_pressure, chamber_2_pressure, valve_supply_pressure,
    internal_leakage_flow. A study keeps none unless this is stated."""

    compression: Literal["none", "lzf", "gzip"] = "none"
    """Compression of the signals."""

    dtype: Literal["float32", "float64"] = "float64"
    """Precision of the stored signals; features are always computed and stored in double precision."""
