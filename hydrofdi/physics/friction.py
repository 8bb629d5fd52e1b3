"""Friction of piston and seals. Each law is a function and one entry in `LAWS`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from hydrofdi.physics import Quantity, equation, sine
from hydrofdi.physics.hydraulic_mode import second_order_eigenvalues

FrictionParameters: TypeAlias = Any
"""Fields of the section ``friction`` in SI, by their names there; each law uses some of them."""

Friction = Callable[[float, float, FrictionParameters], tuple[float, float]]
"""Velocity [m/s], bristle deflection [m], parameters → force [N] and deflection rate [m/s]."""

Eigenvalues = Callable[[FrictionParameters, float, float], list[complex]]
"""Parameters, moving mass [kg], speed [m/s] → eigenvalues [1/s]."""


@dataclass(frozen=True)
class FrictionLaw:
    """A friction law.

    Attributes
    ----------
    name : str
        Value of ``friction.law``.
    friction : callable
        Function registered with `equation`, so that compiled code inlines it.
    zone : str
        Term for the step-size limit, as it appears in messages.
    eigenvalues : callable
        Eigenvalues that limit the step size.
    parameters : frozenset of str
        Fields of the section ``friction`` that this law uses but some other law does not.
    has_bristles : bool
        Whether the bristle deflection is a state.
    """

    name: str
    friction: Friction
    zone: str
    eigenvalues: Eigenvalues
    parameters: frozenset[str]
    has_bristles: bool = False


def _slope_at_rest(friction: Friction) -> Eigenvalues:
    """Eigenvalue function of a law without bristles: damping rate of a piston near rest [1/s]."""

    def eigenvalues(p: FrictionParameters, mass: float, speed: float) -> list[complex]:
        # So slow that the force is linear in the velocity, and their quotient is the slope at rest.
        slow = 1e-3 * p.velocity_threshold
        rate = friction(slow, 0.0, p)[0] / slow / mass
        return [complex(-rate)] if rate > 0.0 else []

    return eigenvalues


@equation
def decaying_exponential(exponent: Quantity) -> Quantity:
    """e^(−x) for x ≥ 0, in operations that a compiler can vectorise.

    The 6th-degree Taylor polynomial of e^(−x/64), raised to the power of 64; x is limited to 64. The absolute
    error is below 3e-12.
    """
    # e^(−64) = 2e-28 is far below the stated error, and keeps y within −1 … 0.
    y = np.minimum(exponent, 64.0) * (-1.0 / 64.0)
    y2 = y * y
    # Estrin's scheme: pairs of terms in parallel, a shorter chain of dependent operations than Horner's.
    low = (1.0 + y) + y2 * (0.5 + y * (1.0 / 6.0))
    high = (1.0 / 24.0 + y * (1.0 / 120.0)) + y2 * (1.0 / 720.0)
    root = low + (y2 * y2) * high
    # Six squarings raise the root to the power of 64.
    power = root * root
    power = power * power
    power = power * power
    power = power * power
    power = power * power
    return power * power


@equation
def stribeck_force(speed: float, p: FrictionParameters) -> float:
    """Dry friction at a speed [m/s]: F_c + (F_brk − F_c) e^(−c_v·speed) [N]."""
    force: float = p.coulomb + (p.breakaway - p.coulomb) * decaying_exponential(p.transition * speed)
    return force


@equation
def dry_friction_factor(
    pressure_difference: float, position: float, pressure_slope: float, share: float, period: float
) -> float:
    """Factor on the dry friction by pressure on the seals and by place in the cylinder.

    Parameters
    ----------
    pressure_difference : float
        P_1 − P_2 [Pa].
    position : float
        x_p [m].
    pressure_slope : float
        Relative rise c_P per pressure difference [1/Pa].
    share : float
        Relative amplitude c_x over the stroke [-].
    period : float
        Length λ of a period of the stroke [m].

    Returns
    -------
    float
        (1 + c_P abs(P_1 − P_2)) (1 + c_x sin(2π x_p/λ)) [-], on F_c and F_brk.
    """
    # A turn of the sine is a period of the stroke.
    place: float = 1.0 + share * sine(position / period)
    return (1.0 + pressure_slope * abs(pressure_difference)) * place  # (12c)


@equation
def threshold_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """Friction force that opposes the motion of the piston [N], and a bristle rate of zero.

    Equation (12) without a branch: above and below v_th f v_p plus the Stribeck force at max(abs(v_p), v_th),
    times v_p/v_th limited to ±1.
    """
    # (12): the floor holds the Stribeck force of v_th within the zone, so the force has no step at its ends.
    speed = np.maximum(np.abs(velocity), p.velocity_threshold)
    stribeck = stribeck_force(speed, p)
    direction = np.minimum(np.maximum(velocity / p.velocity_threshold, -1.0), 1.0)
    return p.viscous * velocity + stribeck * direction, 0.0


THRESHOLD = FrictionLaw(
    "threshold",
    threshold_friction,
    zone="friction zone",
    eigenvalues=_slope_at_rest(threshold_friction),
    parameters=frozenset({"velocity_threshold"}),
)


@equation
def smooth_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """Stribeck friction, smooth at zero velocity, and a bristle rate of zero.

    F_f = [F_c + (F_brk − F_c) e^(−c_v·abs(v_p))] tanh(v_p/v_th) + f v_p [N].
    """
    speed = abs(velocity)
    stribeck = stribeck_force(speed, p)
    # (12a): tanh x = (1 − e^(−2x))/(1 + e^(−2x)) for x ≥ 0, an exponential that cannot overflow.
    decay = decaying_exponential(2.0 * speed / p.velocity_threshold)
    size = stribeck * (1.0 - decay) / (1.0 + decay)
    return p.viscous * velocity + size * np.copysign(1.0, velocity), 0.0


SMOOTH = FrictionLaw(
    "smooth",
    smooth_friction,
    zone="friction zone",
    eigenvalues=_slope_at_rest(smooth_friction),
    parameters=frozenset({"velocity_threshold"}),
)


SMALLEST_FORCE = 1e-9
"""Dry friction below which bristles are ignored [N]."""


@equation
def bristle_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """Friction force [N] of bristles between two surfaces, and their deflection rate [m/s] (LuGre).

    z' = v_p − σ_0 abs(v_p) z/g with g = F_c + (F_brk − F_c) e^(−c_v·abs(v_p)), and
    F_f = σ_0 z + σ_1 z' + f v_p; in steady motion, the Stribeck force plus f v_p.
    """
    speed = abs(velocity)
    # (12b): the floor keeps the quotient finite if there is no dry friction.
    stribeck = np.maximum(stribeck_force(speed, p), SMALLEST_FORCE)
    rate = velocity - p.bristle_stiffness * speed * bristle / stribeck
    return p.bristle_stiffness * bristle + p.bristle_damping * rate + p.viscous * velocity, rate


def _eigenvalues(p: FrictionParameters, mass: float, speed: float) -> list[complex]:
    """Eigenvalues [1/s] of sticking bristles and of bristles that reverse at a given speed."""
    stiffness, damping = p.bristle_stiffness, p.bristle_damping
    if not stiffness:
        return []
    # Sticking, z' = v_p: a mass on the spring σ_0 and the damper σ_1 + f.
    frequency = math.sqrt(stiffness / mass)
    ratio = (damping + p.viscous) / (2.0 * mass * frequency)
    stribeck = stribeck_force(speed, p)
    # Just after a reversal z = −sgn(v_p) g/σ_0, so z' = 2 v_p: hence 2 σ_1; last term: the rate of z alone.
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


LAWS = (THRESHOLD, SMOOTH, LUGRE)
"""All friction laws; the first is the law of the paper."""

FRICTION_LAWS = {law.name: law for law in LAWS}
"""Value of ``friction.law`` → law."""

LIMITED_PARAMETERS = sorted(frozenset[str]().union(*(law.parameters for law in LAWS)))
"""Parameters that only some laws use."""


def laws_that_use(parameter: str) -> tuple[str, ...]:
    """Names of the laws that use one of `LIMITED_PARAMETERS`."""
    return tuple(law.name for law in LAWS if parameter in law.parameters)
