"""What a law of friction is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol


class FrictionParameters(Protocol):
    """Parameters of friction, in SI; a law uses some of them."""

    @property
    def coulomb(self) -> float:
        """F_c [N]."""

    @property
    def breakaway(self) -> float:
        """F_brk [N]."""

    @property
    def viscous(self) -> float:
        """The coefficient f [N·s/m]."""

    @property
    def transition(self) -> float:
        """The coefficient c_v [s/m]."""

    @property
    def velocity_threshold(self) -> float:
        """v_th [m/s]."""

    @property
    def bristle_stiffness(self) -> float:
        """σ_0 [N/m]."""

    @property
    def bristle_damping(self) -> float:
        """σ_1 [N·s/m]."""


Friction = Callable[[float, float, FrictionParameters], tuple[float, float]]
"""Velocity [m/s], deflection of bristles [m], parameters → force [N] and rate of the deflection [m/s]."""

Eigenvalues = Callable[[FrictionParameters, float, float], list[complex]]
"""Parameters, moved mass [kg] and speed [m/s] → eigenvalues [1/s]."""


@dataclass(frozen=True)
class FrictionLaw:
    """A law of friction.

    Attributes
    ----------
    name : str
        Value of ``friction.law``.
    friction : callable
        An `equation`; compiled code inlines it.
    zone : str
        What limits the step, in the words of a message.
    eigenvalues : callable
        What the step has to be short enough for.
    parameters : frozenset of str
        Fields of the section ``friction`` that have an effect with some laws only, this one among them.
    has_bristles : bool
        Whether the deflection of bristles is a state.
    """

    name: str
    friction: Friction
    zone: str
    eigenvalues: Eigenvalues
    parameters: frozenset[str]
    has_bristles: bool = False


def slope_at_rest(friction: Friction) -> Eigenvalues:
    """The rate at which a law without bristles brakes a piston that is nearly at rest [1/s]."""

    def eigenvalues(p: FrictionParameters, mass: float, speed: float) -> list[complex]:
        slow = 1e-3 * p.velocity_threshold
        rate = friction(slow, 0.0, p)[0] / slow / mass
        return [complex(-rate)] if rate > 0.0 else []

    return eigenvalues
