"""Smooth friction: a hyperbolic tangent replaces the sign of the velocity."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.law import FrictionLaw, FrictionParameters, slope_at_rest
from hydrofdi.physics.friction.stribeck import decaying_exponential, stribeck_force


@equation
def smooth_friction_force(
    velocity: float,
    coulomb: float,
    breakaway: float,
    viscous: float,
    transition: float,
    velocity_threshold: float,
) -> float:
    """Stribeck friction, smooth at zero velocity.

    Parameters
    ----------
    velocity, coulomb, breakaway, viscous, transition, velocity_threshold : float
        As for `friction_force`.

    Returns
    -------
    float
        F_f = [F_c + (F_brk − F_c) e^(−c_v·abs(v_p))] tanh(v_p/v_th) + f v_p [N].
    """
    speed = abs(velocity)
    stribeck = stribeck_force(speed, coulomb, breakaway, transition)
    decay = decaying_exponential(2.0 * speed / velocity_threshold)
    size = stribeck * (1.0 - decay) / (1.0 + decay)
    direction: float = np.copysign(1.0, velocity)
    return viscous * velocity + size * direction


@equation
def smooth_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """`smooth_friction_force` [N] and a bristle rate of zero."""
    force = smooth_friction_force(
        velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold
    )
    return force, 0.0


SMOOTH = FrictionLaw(
    "smooth",
    smooth_friction,
    zone="friction zone",
    eigenvalues=slope_at_rest(smooth_friction),
    parameters=frozenset({"velocity_threshold"}),
)
