"""LuGre friction: bristles deflect before they slide.

Canudas de Wit et al., IEEE Trans. Automatic Control 40 (1995).
"""

from __future__ import annotations

import math

from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.law import FrictionLaw, FrictionParameters
from hydrofdi.physics.friction.stribeck import stribeck_force
from hydrofdi.physics.stability import second_order_eigenvalues

SMALLEST_FORCE = 1e-9
"""Dry friction below which bristles are ignored [N]."""


@equation
def bristle_rate(
    velocity: float, deflection: float, coulomb: float, breakaway: float, transition: float, stiffness: float
) -> float:
    """Deflection rate of the bristles between two surfaces (LuGre).

    Parameters
    ----------
    velocity : float
        v_p [m/s].
    deflection : float
        Mean deflection z of the bristles [m].
    coulomb, breakaway : float
        F_c and F_brk [N].
    transition : float
        c_v [s/m].
    stiffness : float
        σ_0 [N/m].

    Returns
    -------
    float
        z' = v_p − σ_0 abs(v_p) z/g [m/s], with g = F_c + (F_brk − F_c) e^(−c_v·abs(v_p)).
    """
    speed = abs(velocity)
    stribeck = stribeck_force(speed, coulomb, breakaway, transition)
    return velocity - stiffness * speed * deflection / max(stribeck, SMALLEST_FORCE)


@equation
def bristle_friction_force(
    velocity: float, deflection: float, rate: float, stiffness: float, damping: float, viscous: float
) -> float:
    """Friction force of deflected bristles (LuGre).

    Parameters
    ----------
    velocity : float
        v_p [m/s].
    deflection, rate : float
        z [m] and z' [m/s].
    stiffness, damping, viscous : float
        σ_0 [N/m], σ_1 and f [N·s/m].

    Returns
    -------
    float
        F_f = σ_0 z + σ_1 z' + f v_p [N]; in steady motion, the Stribeck force plus f v_p.
    """
    return stiffness * deflection + damping * rate + viscous * velocity


@equation
def bristle_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """`bristle_friction_force` [N] and `bristle_rate` [m/s]."""
    rate = bristle_rate(velocity, bristle, p.coulomb, p.breakaway, p.transition, p.bristle_stiffness)
    force = bristle_friction_force(velocity, bristle, rate, p.bristle_stiffness, p.bristle_damping, p.viscous)
    return force, rate


def _eigenvalues(p: FrictionParameters, mass: float, speed: float) -> list[complex]:
    """Eigenvalues [1/s] of sticking bristles and of bristles that reverse at a given speed."""
    stiffness, damping = p.bristle_stiffness, p.bristle_damping
    if not stiffness:
        return []
    frequency = math.sqrt(stiffness / mass)
    ratio = (damping + p.viscous) / (2.0 * mass * frequency)
    stribeck = stribeck_force(speed, p.coulomb, p.breakaway, p.transition)
    sliding = (2.0 * damping + p.viscous) / mass + stiffness * speed / max(stribeck, SMALLEST_FORCE)
    return [*second_order_eigenvalues(frequency, ratio), complex(-sliding)]


LUGRE = FrictionLaw(
    "lugre",
    bristle_friction,
    zone="bristles",
    eigenvalues=_eigenvalues,
    parameters=frozenset({"bristle_stiffness", "bristle_damping"}),
    has_bristles=True,
)
