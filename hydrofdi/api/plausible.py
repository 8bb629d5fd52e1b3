"""Is it a usual machine? Its parameters, and mode, load, speed, stroke and damping of its runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from hydrofdi.api.step_limits import Distinct
from hydrofdi.config import RunParameters
from hydrofdi.config.plausibility import Unusual
from hydrofdi.config.request import EDGES
from hydrofdi.quality.machine import at_speed, natural_frequency
from hydrofdi.report.table import Table
from hydrofdi.settings.messages import counted
from hydrofdi.settings.readable import plain, readable_unit, typeset
from hydrofdi.units import convert

Row = Mapping[str, Any]


class Quantity(NamedTuple):
    """A quantity [in `unit`] of a run, its row of results and its mode; its usual range, what to change
    below and above it, and the sections that it depends on if it needs no results.
    """

    name: str
    unit: str
    least: float
    most: float
    of: Callable[[RunParameters, Row, Row], float]
    below: str
    above: str
    sections: tuple[str, ...] = ()


def load_share(run: RunParameters, row: Row) -> float:
    """Largest load of forces, weight and spring, over supply pressure times the smaller area [%]."""
    actuator, load = run.actuator, run.load
    force = abs(load.constant_force + actuator.weight) + load.random_force
    reached = max(abs(float(row[f"piston_position_{end}"])) for end in ("min", "max"))
    # A run that failed has no positions; its load is that of the forces.
    force += actuator.load_stiffness * (reached if math.isfinite(reached) else 0.0)
    return 100.0 * force / (run.supply.pressure * min(actuator.areas))


def valve_speed(run: RunParameters, *, slower: bool) -> float:
    """Steady speed at the largest opening, in the slower or the faster direction [m/s]."""
    return (min if slower else max)(at_speed(run, motion)[0] for motion in (1.0, -1.0))


def speed_ratio(run: RunParameters) -> float:
    """Speed that the valve allows in the slower direction over the largest that a reference asks for [-].

    NaN without a reference whose period states a speed.
    """
    shares = {"square": 4.0, "steps": 2.0, "sine": 2.0 * math.pi}
    if not run.control.is_closed or run.input.shape not in shares or not run.control.amplitude:
        return math.nan
    asked = shares[run.input.shape] * abs(run.control.amplitude) / run.input.period
    return valve_speed(run, slower=True) / asked


def slenderness(run: RunParameters) -> float:
    """Stroke, or where a chamber vanishes, over the diameter of a circle of the area A_1 [-]."""
    low, high = run.actuator.ends
    return (high - low) / math.sqrt(4.0 / math.pi * run.actuator.piston_area)


_OF_SPEED = ("actuator", "supply", "valve", *EDGES, "load", "input", "control", "record")

QUANTITIES = (
    Quantity(
        "stroke over piston diameter", "", 0.1, 40.0, lambda run, row, mode: slenderness(run),
        "check actuator.stroke and actuator.piston_area",
        "check actuator.stroke, without it actuator.chamber_volume: a rod of this length buckles",
        ("actuator",),
    ),
    Quantity(
        "natural frequency f_h", "Hz", 1.0, 500.0, lambda run, row, mode: natural_frequency(run),
        "check fluid.bulk_modulus and the units of actuator.piston_area; or lower actuator.mass",
        "check actuator.mass; or raise actuator.chamber_volume",
        ("actuator", "fluid", "supply"),
    ),
    Quantity(
        "load over the force", "%", 5.0, 75.0, lambda run, row, mode: load_share(run, row),
        "raise load.constant_force or load.random_force: a seal without a load hardly leaks",
        "check supply.pressure and actuator.piston_area; or lower the load",
    ),
    Quantity(
        "largest valve speed", "m/s", 0.005, 1.5,
        lambda run, row, mode: valve_speed(run, slower=False),
        "raise valve.area_gradient; check the pressure drop of the rated flow",
        "lower valve.area_gradient; check the pressure drop of the rated flow",
        _OF_SPEED,
    ),
    Quantity(
        "valve speed over motion speed", "", 1.0, 10.0, lambda run, row, mode: speed_ratio(run),
        "raise valve.area_gradient; or lower control.amplitude, or raise input.period",
        "lower valve.area_gradient; or raise control.amplitude, or lower input.period",
        _OF_SPEED,
    ),
    Quantity(
        "stroke used", "%", 5.0, 95.0, lambda run, row, mode: 100.0 * mode["stroke_share"],
        "raise control.amplitude (open loop: input.amplitude)",
        "lower control.amplitude (open loop: input.amplitude or input.period)",
    ),
    Quantity(
        "hydraulic damping ζ, in motion", "", 0.02, 1.0, lambda run, row, mode: mode["damping_ratio"],
        "raise friction.viscous or valve.lap_leakage: real cylinders are damped better",
        "lower friction.viscous, or check the leakage",
    ),
    Quantity(
        "time with a cavitating chamber", "%", 0.0, 0.0,
        lambda run, row, mode: 100.0 * float(row["cavitating_share"]),
        "",
        "lower the load, or control.voltage_limit: the valve cannot feed the chamber that the load opens",
    ),
)  # fmt: skip
"""What follows from the parameters first, then what the motion shows."""


def plausibility(
    unusual: Iterable[Unusual],
    distinct: Distinct,
    runs: Sequence[RunParameters],
    rows: Sequence[Row],
    modes: Sequence[Row],
) -> list[dict[str, Any]]:
    """Unusual parameters, and the range of each quantity, with their usual range.

    What needs no results is that of all machines, all else that of the simulated runs. ``change`` says what
    to change if some value is outside, and in how many of them if not in all.
    """
    found = [
        _row(each.name, each.unit, [*map(abs, each.values)], each.usual, "check its value and its unit")
        for each in unusual
    ]
    for quantity in QUANTITIES:
        seen: Iterable[tuple[RunParameters, Row, Row]] = zip(runs, rows, modes, strict=True)
        if quantity.sections:
            seen = ((run, {}, {}) for run in distinct(*quantity.sections))
        own = [value for each in seen if math.isfinite(value := float(quantity.of(*each)))]
        n_low, n_high = sum(each < quantity.least for each in own), sum(each > quantity.most for each in own)
        change = quantity.below if n_low > n_high else quantity.above if n_high else ""
        n_outside = max(n_low, n_high)
        of_all = counted(len(own), "machine" if quantity.sections else "run")
        where = f"in {n_outside} of {of_all}: " if 0 < n_outside < len(own) else ""
        if own:
            usual = quantity.least, quantity.most
            found.append(_row(quantity.name, quantity.unit, own, usual, where + change))
    return found


def _row(
    name: str, unit: str, values: Sequence[float], usual: tuple[float, float], change: str
) -> dict[str, Any]:
    ends = {"least": min(values), "largest": max(values)}
    return {"quantity": name, "unit": unit, **ends, "usual": [*usual], "change": change}


def plausibility_table(found: Sequence[Row]) -> Table:
    """The quantities, with their usual ranges, in readable units, and what to change."""

    def text(low: float, high: float, own: str) -> str:
        unit = readable_unit(own, high)
        ends = dict.fromkeys(plain(convert(each, unit) if unit != own else each, 3) for each in (low, high))
        return f"{' … '.join(ends)} {typeset(unit)}".removesuffix(" 1").rstrip()

    columns = {
        "quantity": [each["quantity"] for each in found],
        "here": [text(each["least"], each["largest"], each["unit"]) for each in found],
        "usual": [text(each["usual"][0], each["usual"][1], each["unit"]) for each in found],
    }
    notes = (f"{each['quantity']}: {each['change']}" for each in found if each["change"])
    return Table.of(columns, title="Plausibility", notes=tuple(notes))
