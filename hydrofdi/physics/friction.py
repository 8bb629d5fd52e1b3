"""Friction of piston and seals. Each law is a function and one entry in `LAWS`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from hydrofdi.physics.equation import equation
from hydrofdi.physics.stability import second_order_eigenvalues

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
        slow = 1e-3 * p.velocity_threshold
        rate = friction(slow, 0.0, p)[0] / slow / mass
        return [complex(-rate)] if rate > 0.0 else []

    return eigenvalues


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
def _threshold_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """`friction_force` [N] and a bristle rate of zero."""
    force = friction_force(velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold)
    return force, 0.0


THRESHOLD = FrictionLaw(
    "threshold",
    _threshold_friction,
    zone="friction zone",
    eigenvalues=_slope_at_rest(_threshold_friction),
    parameters=frozenset({"velocity_threshold"}),
)


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
def _smooth_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
    """`smooth_friction_force` [N] and a bristle rate of zero."""
    force = smooth_friction_force(
        velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold
    )
    return force, 0.0


SMOOTH = FrictionLaw(
    "smooth",
    _smooth_friction,
    zone="friction zone",
    eigenvalues=_slope_at_rest(_smooth_friction),
    parameters=frozenset({"velocity_threshold"}),
)


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
def _bristle_friction(velocity: float, bristle: float, p: FrictionParameters) -> tuple[float, float]:
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
    _bristle_friction,
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


Choice = tuple[bool | None, ...]
"""True at the index of the chosen law, None elsewhere.

This gives each law its own type, and so its own compiled code.
"""


def choice_of_law(name: str) -> Choice:
    """`Choice` of the law with this name."""
    return tuple(law.name == name or None for law in LAWS)


PAPER_FRICTION = choice_of_law(LAWS[0].name)
"""`Choice` of the paper's law."""


def _first_chosen(place: int) -> Any:
    """Friction function of the chosen law, searched from index `place` on.

    Compiled code contains only the chosen law.
    """
    law: Friction = LAWS[place].friction
    if place + 1 == len(LAWS):

        @equation
        def last(
            velocity: float, bristle: float, p: FrictionParameters, choice: Choice
        ) -> tuple[float, float]:
            return law(velocity, bristle, p)

        return last
    others = _first_chosen(place + 1)

    @equation
    def chosen(velocity: float, bristle: float, p: FrictionParameters, choice: Choice) -> tuple[float, float]:
        if choice[place] is not None:
            return law(velocity, bristle, p)
        friction: tuple[float, float] = others(velocity, bristle, p, choice)
        return friction

    return chosen


chosen_friction = _first_chosen(0)
"""Function that returns friction force [N] and bristle rate [m/s] of the chosen law."""
