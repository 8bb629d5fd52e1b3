"""Stribeck force, shared by the laws of dry friction."""

from __future__ import annotations

from hydrofdi.physics.equation import equation


@equation
def decaying_exponential(exponent: float) -> float:
    """e^(−x) for x ≥ 0, in operations that a compiler can vectorise.

    The 6th-degree Taylor polynomial of e^(−x/64), raised to the power of 64; x is limited to 64. The absolute
    error is below 3e-12.
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
    """Dry friction at a speed [m/s]: F_c + (F_brk − F_c) e^(−c_v·speed) [N], c_v in s/m."""
    return coulomb + (breakaway - coulomb) * decaying_exponential(transition * speed)
