"""Is it a usual machine? Mode, load, speed, stroke, damping and cavitation of the runs, causes first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple

from hydrofdi.api.step_limits import undamped_frequency
from hydrofdi.config import RunParameters
from hydrofdi.quality.machine import machine_figures
from hydrofdi.report.table import Table
from hydrofdi.settings.readable import plain


class Quantity(NamedTuple):
    """A quantity with its usual range, and what to change below and above it."""

    name: str
    unit: str
    least: float
    most: float
    below: str
    above: str


QUANTITIES = {
    "frequency": Quantity(
        "natural frequency f_h", "Hz", 1.0, 500.0,
        "check fluid.bulk_modulus and the units of actuator.piston_area; or lower actuator.mass",
        "check actuator.mass; or raise actuator.chamber_volume",
    ),
    "load": Quantity(
        "load over the force", "%", 5.0, 75.0,
        "raise load.constant_force or load.random_force: a seal without a load hardly leaks",
        "check supply.pressure and actuator.piston_area; or lower the load",
    ),
    "speed": Quantity(
        "speed of the valve over that of the motion", "", 0.25, 10.0,
        "raise valve.area_gradient; or lower control.amplitude, or raise input.period",
        "lower valve.area_gradient; or raise control.amplitude, or lower input.period",
    ),
    "stroke": Quantity(
        "stroke used", "%", 5.0, 95.0,
        "raise control.amplitude (open loop: input.amplitude)",
        "lower control.amplitude (open loop: input.amplitude or input.period)",
    ),
    "damping": Quantity(
        "damping ratio ζ", "", 0.02, 1.0,
        "raise friction.viscous or valve.lap_leakage: real cylinders are damped better",
        "lower friction.viscous, or check the leakage",
    ),
    "cavitation": Quantity(
        "time with a cavitating chamber", "%", 0.0, 0.0,
        "",
        "lower the load, or control.voltage_limit: the valve cannot feed the chamber that the load opens",
    ),
}  # fmt: skip
"""Key → quantity: what follows from the parameters first, then what the motion shows."""


def load_share(run: RunParameters, furthest: float) -> float:
    """Largest load of forces, weight and spring, over supply pressure times the smaller area [-].

    `furthest` is the largest distance from the centre [m].
    """
    actuator, load = run.actuator, run.load
    force = abs(load.constant_force + actuator.weight) + load.random_force
    return (force + actuator.load_stiffness * furthest) / (run.supply.pressure * min(actuator.areas))


def speed_ratio(run: RunParameters) -> float:
    """Speed that the valve allows in the slower direction over the largest that a reference asks for [-].

    NaN without a reference whose period states a speed.
    """
    shares = {"square": 4.0, "steps": 2.0, "sine": 2.0 * math.pi}
    if not run.control.is_closed or run.input.shape not in shares or not run.control.amplitude:
        return math.nan
    asked = shares[run.input.shape] * abs(run.control.amplitude) / run.input.period
    figures = machine_figures(run)
    return min(figures[f"speed_{direction}"] for direction in ("extending", "retracting")) / asked


def plausibility(
    runs: Sequence[RunParameters], rows: Sequence[Mapping[str, Any]], modes: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """Range of each quantity over the runs, its usual range, and what to change if their median is outside.

    Time with cavitation is unusual in any run.
    """
    ends = ("piston_position_min", "piston_position_max")
    # A run that failed has no positions; its load is that of the forces.
    reached = [max(abs(float(row[end])) for end in ends) for row in rows]
    furthest = [each if math.isfinite(each) else 0.0 for each in reached]
    values = {
        "frequency": [undamped_frequency(run) / (2.0 * math.pi) for run in runs],
        "load": [100.0 * load_share(run, each) for run, each in zip(runs, furthest, strict=True)],
        "speed": [speed_ratio(run) for run in runs],
        "stroke": [100.0 * mode["stroke_share"] for mode in modes],
        "damping": [mode["damping_ratio"] for mode in modes],
        "cavitation": [100.0 * float(row["cavitating_share"]) for row in rows],
    }
    found = []
    for key, quantity in QUANTITIES.items():
        own = [value for value in values[key] if math.isfinite(value)]
        if own:
            low, high = min(own), max(own)
            middle = high if key == "cavitation" else median(own)
            change = quantity.above if middle > quantity.most else ""
            change = quantity.below if middle < quantity.least else change
            found.append({
                "quantity": quantity.name, "unit": quantity.unit, "least": low, "largest": high,
                "usual": [quantity.least, quantity.most], "change": change,
            })  # fmt: skip
    return found


def plausibility_table(found: Sequence[Mapping[str, Any]]) -> Table:
    """The quantities, with their usual ranges."""

    def text(values: tuple[float, float], unit: str) -> str:
        low, high = (plain(value, 3) for value in values)
        return f"{low if low == high else f'{low} … {high}'} {unit}".rstrip()

    columns = {
        "quantity": [each["quantity"] for each in found],
        "here": [text((each["least"], each["largest"]), each["unit"]) for each in found],
        "usual": [text(each["usual"], each["unit"]) for each in found],
        "change": [each["change"] or "–" for each in found],
    }
    return Table.of(columns, title="Plausibility")
