"""The longest Runge-Kutta step that each part of a run allows."""

from __future__ import annotations

import math
from collections.abc import Iterable

from hydrofdi.config import RunParameters
from hydrofdi.physics.friction import SMALLEST_FORCE, friction_force, smooth_friction_force
from hydrofdi.physics.hydraulic_mode import HydraulicMode, mode_frequency
from hydrofdi.physics.stability import largest_stable_step, second_order_eigenvalues
from hydrofdi.simulation.no_load import no_load_speed


def step_limits(run: RunParameters, mode: HydraulicMode | None = None) -> dict[str, float]:
    """Longest stable step for each part of the model that a run has.

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
    limits = {"valve": _lag_limit(valve.angular_frequency, valve.damping_ratio)}
    omega = mode_frequency(
        run.fluid.bulk_modulus, actuator.piston_area, actuator.chamber_volume, actuator.mass,
        actuator.load_stiffness,
    )  # fmt: skip
    if mode is None:
        limits["hydraulic mode"] = _lag_limit(omega, 0.0)
    else:
        limits["hydraulic mode"] = _lag_limit(2.0 * math.pi * mode.frequency, mode.damping_ratio)
    if friction.law == "lugre":
        limits["bristles"] = _bristle_limit(run)
    elif (rate := _friction_rate(run)) > 0.0:
        limits["friction zone"] = largest_stable_step(complex(-rate))
    if actuator.end_stops == "elastic":
        stiffness = actuator.mass * omega**2 + actuator.end_stop_stiffness
        limits["end stops"] = _lag_limit(math.sqrt(stiffness / actuator.mass), 0.0)
    if run.supply.droop == "first_order":
        limits["supply"] = largest_stable_step(complex(-1.0 / run.supply.droop_time_constant))
    return limits


def _friction_rate(run: RunParameters) -> float:
    """Slope of the friction force at rest over the mass [1/s]."""
    friction = run.friction
    law = smooth_friction_force if friction.law == "smooth" else friction_force
    slow = 1e-3 * friction.velocity_threshold
    force = law(
        slow, friction.dry_coulomb, friction.dry_breakaway, friction.viscous, friction.transition,
        friction.velocity_threshold,
    )  # fmt: skip
    return force / slow / run.actuator.mass


def _bristle_limit(run: RunParameters) -> float:
    """Longest step for bristles that stick, and that slide at the no-load speed."""
    friction, mass = run.friction, run.actuator.mass
    stiffness = friction.dry_bristle_stiffness
    if not stiffness:
        return math.inf
    frequency = math.sqrt(stiffness / mass)
    ratio = (friction.dry_bristle_damping + friction.viscous) / (2.0 * mass * frequency)
    sliding = stiffness * no_load_speed(run) / max(friction.dry_coulomb, SMALLEST_FORCE)
    return min(_lag_limit(frequency, ratio), largest_stable_step(complex(-sliding)) if sliding else math.inf)


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
