"""Friction of piston and seals: one module for each law, and one line here."""

from __future__ import annotations

from typing import Any

from hydrofdi.physics.equation import equation
from hydrofdi.physics.friction.law import Friction, FrictionLaw, FrictionParameters
from hydrofdi.physics.friction.lugre import LUGRE
from hydrofdi.physics.friction.smooth import SMOOTH
from hydrofdi.physics.friction.threshold import THRESHOLD

LAWS = (THRESHOLD, SMOOTH, LUGRE)
"""The laws; the first is that of the paper."""

FRICTION_LAWS = {law.name: law for law in LAWS}
"""Value of ``friction.law`` → law."""

LIMITED_PARAMETERS = sorted(frozenset[str]().union(*(law.parameters for law in LAWS)))
"""Parameters that have an effect with some laws only."""


def laws_that_use(parameter: str) -> tuple[str, ...]:
    """Names of the laws that one of `LIMITED_PARAMETERS` has an effect with."""
    return tuple(law.name for law in LAWS if parameter in law.parameters)


Choice = tuple[bool | None, ...]
"""True at the place of a law, None elsewhere: a type of its own for each law, so that each is compiled."""


def choice_of_law(name: str) -> Choice:
    """The choice of a law by its name."""
    return tuple(law.name == name or None for law in LAWS)


PAPER_FRICTION = choice_of_law(LAWS[0].name)
"""The choice of the paper's law."""


def _first_chosen(place: int) -> Any:
    """Friction by the chosen law, from some place on; compiled code contains only that law."""
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
"""Friction force [N] by the chosen law, and the rate of its bristles [m/s]."""

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
