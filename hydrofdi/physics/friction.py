"""Stribeck friction with a linear zone around zero velocity."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import equation

SMALLEST_FORCE = 1e-9
"""Dry friction below which there are no bristles [N]."""


@equation
def decaying_exponential(exponent: float) -> float:
    """e^(−x) for x ≥ 0, in operations that a compiler can run side by side in SIMD lanes.

    The Taylor polynomial of degree 6 of e^(−x/64), to the power of 64; x is limited to 64. The absolute
    error is below 3e-12 everywhere.
    """
    y = min(exponent, 64.0) * (-1.0 / 64.0)
    y2 = y * y
    low = (1.0 + y) + y2 * (0.5 + y * (1.0 / 6.0))
    high = (1.0 / 24.0 + y * (1.0 / 120.0)) + y2 * (1.0 / 720.0)
    root = low + (y2 * y2) * high
    power = root * root
    power = power * power
    power = power * power
    power = power * power
    power = power * power
    return power * power


@equation
def stribeck_force(speed: float, coulomb: float, breakaway: float, transition: float) -> float:
    """Size of the dry friction at a speed [m/s]: F_c + (F_brk − F_c) e^(−c_v·speed) [N]; c_v in s/m."""
    return coulomb + (breakaway - coulomb) * decaying_exponential(transition * speed)


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
        v_th [m/s]; friction is linear below it.

    Returns
    -------
    float
        F_f [N]. Equation (12), written without a branch: both of its cases are f v_p plus the
        Stribeck force at max(abs(v_p), v_th) times v_p/v_th limited to ±1.
    """
    speed = max(abs(velocity), velocity_threshold)
    stribeck = stribeck_force(speed, coulomb, breakaway, transition)
    direction = min(max(velocity / velocity_threshold, -1.0), 1.0)
    return viscous * velocity + stribeck * direction


@equation
def smooth_friction_force(
    velocity: float,
    coulomb: float,
    breakaway: float,
    viscous: float,
    transition: float,
    velocity_threshold: float,
) -> float:
    """Stribeck friction without a kink.

    Parameters
    ----------
    velocity, coulomb, breakaway, viscous, transition, velocity_threshold : float
        As of `friction_force`.

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
def bristle_rate(
    velocity: float, deflection: float, coulomb: float, breakaway: float, transition: float, stiffness: float
) -> float:
    """Rate at which the bristles between two surfaces bend (LuGre).

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
    """Friction force of bent bristles (LuGre).

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
        F_f = σ_0 z + σ_1 z' + f v_p [N]; in steady motion the Stribeck force and f v_p.
    """
    return stiffness * deflection + damping * rate + viscous * velocity
