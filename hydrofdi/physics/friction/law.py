"""Interface of a friction law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

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


def slope_at_rest(friction: Friction) -> Eigenvalues:
    """Eigenvalue function of a law without bristles: damping rate of a piston near rest [1/s]."""

    def eigenvalues(p: FrictionParameters, mass: float, speed: float) -> list[complex]:
        slow = 1e-3 * p.velocity_threshold
        rate = friction(slow, 0.0, p)[0] / slow / mass
        return [complex(-rate)] if rate > 0.0 else []

    return eigenvalues
