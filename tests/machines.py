"""Named machines on which all laws are tested, so that few variants of the kernel are compiled.

Each of the four machines after that of the paper has every option of the kernel that it can have, at a value
that changes nothing. A test sets the values of its own option, and the same variant of the kernel runs it.
"""

from typing import Any

from hydrofdi.config import RunParameters

Values = dict[str, Any]

TINY = 1e-30
"""Turns an option on in the kernel, and is lost beside anything else."""

RIG: Values = {
    "actuator.piston_area_2": 633e-6 * (1.0 - 1e-12), "actuator.inclination": TINY,
    "friction.position_share": TINY, "fluid.temperature_rise": TINY,
    "fluid.bulk_modulus_pressure_slope": TINY, "fluid.law": "free_air", "fluid.free_air": 0.0,
    "valve.largest_opening": 1.0, "valve.hysteresis": TINY, "valve.edge_rounding": TINY,
    "valve.null_offset": TINY,
    "actuator.end_stops": "elastic", "actuator.end_stop_stiffness": TINY,
    "actuator.end_stop_position": 1e-3, "actuator.foundation_stiffness": 1e30,
    "actuator.foundation_damping": 1e33, "load.constant_force": TINY, "supply.droop": "first_order",
    "supply.droop_resistance": 0.0, "supply.ripple": TINY, "supply.return_resistance": TINY,
}  # fmt: skip
"""Open loop, orifice, friction with a threshold, no hoses. Nor has the leak options: experiments drop them
where nothing leaks.
"""

_LEAK = {"leakage.drag": TINY, "leakage.scored_width": 1e30, "leakage.onset": "step"}

GAP = RIG | _LEAK | {"leakage.law": "laminar", "friction.law": "smooth"}
"""Open loop, laminar gap, smooth friction, no hoses. In all that leak, the leak sets in."""

HOSES = RIG | _LEAK | {"leakage.law": "blended", "friction.law": "lugre", "actuator.hose_volume": 50e-6}
"""Open loop, blended law of leakage, bristles, hoses."""

LOOP = RIG | _LEAK | {"control.law": "pi", "control.amplitude": 5e-3, "control.feedback": "measured"}
"""Closed loop on a sensor, orifice, friction with a threshold, no hoses."""

_OF_SHEET = (
    "actuator.piston_area_2", "actuator.inclination", "fluid.temperature_rise", "fluid.law",
    "fluid.free_air", "valve.hysteresis", "valve.null_offset", "load.constant_force",
    "control.law", "control.amplitude", "control.feedback",
)  # fmt: skip
SHEET = {name: LOOP[name] for name in _OF_SHEET} | {"valve.lap_leakage": TINY}
"""Closed loop with what the ready machines of inclined cylinders have, which run the same variants."""

MACHINES: dict[str, Values] = {"paper": {}, "rig": RIG, "gap": GAP, "hoses": HOSES, "loop": LOOP}


def settings_of(values: Values) -> tuple[str, ...]:
    """The values as settings of a command."""
    return tuple(f"{name}={value}" for name, value in values.items())


def sections_of(values: Values) -> dict[str, Values]:
    """The values as sections of an experiment."""
    sections: dict[str, Values] = {}
    for name, value in values.items():
        section, _, key = name.partition(".")
        sections.setdefault(section, {})[key] = value
    return sections


def machine(changes: Values, base: Values = RIG) -> RunParameters:
    """A record of 1 s of a machine with changed values."""
    return RunParameters().with_values(base | {"record.duration": 1.0, "input.period": 0.5} | changes)
