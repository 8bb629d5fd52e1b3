"""Friction of piston and seals. Each law is one module and one entry in `LAWS`."""

from __future__ import annotations

from typing import Any

from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.law import Friction, FrictionLaw, FrictionParameters
from hydrofdi.physics.friction.lugre import LUGRE
from hydrofdi.physics.friction.smooth import SMOOTH
from hydrofdi.physics.friction.threshold import THRESHOLD

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

__all__ = [
    "FRICTION_LAWS",
    "LAWS",
    "LIMITED_PARAMETERS",
    "PAPER_FRICTION",
    "Choice",
    "FrictionLaw",
    "choice_of_law",
    "chosen_friction",
    "laws_that_use",
]
