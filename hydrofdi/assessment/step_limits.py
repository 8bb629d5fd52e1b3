"""The longest Runge-Kutta step that each part of a run allows."""

from __future__ import annotations

import math
from collections.abc import Iterable

from hydrofdi.config import RunParameters
from hydrofdi.physics.friction import friction_force, smooth_friction_force
from hydrofdi.physics.hydraulic_mode import HydraulicMode, mode_frequency
from hydrofdi.physics.stability import largest_stable_step, second_order_eigenvalues


def step_limits(run: RunParameters, mode: HydraulicMode | None = None) -> dict[str, float]:
    """Longest stable step for the friction zone, the valve and the hydraulic mode.

    Parameters
    ----------
    run : RunParameters
    mode : HydraulicMode, optional
        The mode at the working point; without it, undamped.

    Returns
    -------
    dict
        Name of the part → step [s].
    """
    actuator, friction, valve = run.actuator, run.friction, run.valve
    limits = {"valve": _lag_limit(2.0 * math.pi * valve.natural_frequency, valve.damping_ratio)}
    if mode is None:
        omega = mode_frequency(
            run.fluid.bulk_modulus, actuator.piston_area, actuator.chamber_volume, actuator.mass,
            actuator.load_stiffness,
        )  # fmt: skip
        limits["hydraulic mode"] = _lag_limit(omega, 0.0)
    else:
        limits["hydraulic mode"] = _lag_limit(2.0 * math.pi * mode.frequency, mode.damping_ratio)
    law = smooth_friction_force if friction.law == "smooth" else friction_force
    slow = 1e-3 * friction.velocity_threshold
    force = law(
        slow, friction.dry_coulomb, friction.dry_breakaway, friction.viscous, friction.transition,
        friction.velocity_threshold,
    )  # fmt: skip
    slope = force / slow
    if slope > 0.0:
        limits["friction zone"] = largest_stable_step(complex(-slope / actuator.mass))
    return limits


def step_warnings(runs: Iterable[RunParameters]) -> list[str]:
    """A sentence on each part of the model for which the step of some run is too long."""
    shortest: dict[str, tuple[float, float]] = {}
    for run in dict.fromkeys(runs):
        for part, limit in step_limits(run).items():
            if run.run.step > limit:
                shortest[part] = min(shortest.get(part, (math.inf, 0.0)), (limit, run.run.step))
    return [
        f"the step of {step:g} s is too long for the {part}: Runge-Kutta is stable up to {limit:.3g} s"
        for part, (limit, step) in shortest.items()
    ]


def _lag_limit(frequency: float, damping_ratio: float) -> float:
    return min(largest_stable_step(value) for value in second_order_eigenvalues(frequency, damping_ratio))
