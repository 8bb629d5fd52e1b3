"""Friction that is linear in velocity below a threshold (paper)."""

from __future__ import annotations

from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.law import FrictionLaw, FrictionParameters, slope_at_rest
from hydrofdi.physics.friction.stribeck import stribeck_force


@equation
def friction_force(
    velocity: float,
    coulomb: float,
    breakaway: float,
    viscous: float,
    transition: float,
    velocity_threshold: float,
) -> float:
    """Friction force that opposes the motion of the piston.

    Parameters
    ----------
    velocity : float
        v_p [m/s].
    coulomb, breakaway : float
        F_c and F_brk [N].
    viscous : float
        f [N·s/m].
    transition : float
        c_v [s/m].
    velocity_threshold : float
        v_th [m/s]; friction is linear in velocity below it.

    Returns
    -------
    float
        F_f [N]. Equation (12) without a branch: in both cases f v_p plus the Stribeck force at max(abs(v_p),
        v_th), times v_p/v_th limited to ±1.
    """
    speed = max(abs(velocity), velocity_threshold)
    stribeck = stribeck_force(speed, coulomb, breakaway, transition)
    direction = min(max(velocity / velocity_threshold, -1.0), 1.0)
    return viscous * velocity + stribeck * direction


@equation
def threshold_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """`friction_force` [N] and a bristle rate of zero."""
    force = friction_force(velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold)
    return force, 0.0


THRESHOLD = FrictionLaw(
    "threshold",
    threshold_friction,
    zone="friction zone",
    eigenvalues=slope_at_rest(threshold_friction),
    parameters=frozenset({"velocity_threshold"}),
)
