"""The ``store`` section: what is kept of each run, and how."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, WithJsonSchema

from hydrofdi.settings.messages import nearest
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
    names = NAMED.get(given, given.split(",")) if isinstance(given, str) else given
    is_list = isinstance(names, list | tuple)
    unknown = [name for name in names if name not in SIGNALS] if is_list else []
    if not is_list or (unknown and isinstance(given, str)):
        raise ValueError(f"must be 'all', 'pressures', 'none' or a list of signals; found {given!r}")
    if unknown:
        raise ValueError(f"there is no signal {unknown[0]!r}{nearest(str(unknown[0]), SIGNALS)}")
    kept = tuple(name for name in SIGNALS if name in names)
    return next((word for word, meant in NAMED.items() if meant == kept), ",".join(kept))


Signals = Annotated[
    str,
    BeforeValidator(_as_text),
    WithJsonSchema({"anyOf": [{"enum": list(NAMED)}, {"type": "array", "items": {"enum": list(SIGNALS)}}]}),
]
"""Which signals: ``all``, ``pressures``, ``none``, or names with commas between them."""


class StoreConfig(Section):
    """Content of the experiment file besides the features."""

    signals: Signals = "all"
    """``all`` signals, the chamber ``pressures`` alone, ``none``, or a list of signals to store, such as
    ``[chamber_1_pressure, spool_position]``: input_voltage, reference_position, load_force, spool_position,
    piston_position, piston_velocity, chamber_1_pressure, chamber_2_pressure, valve_supply_pressure,
    internal_leakage_flow. A study stores none by default, but
    ``simulate --out`` stores all of its one run."""

    compression: Literal["none", "lzf", "gzip"] = "none"
    """Compression of the signals."""

    dtype: Literal["float32", "float64"] = "float64"
    """Precision of the stored signals; features are always computed and stored in double precision."""
