"""The equations: small pure functions, each named by the quantity that it returns.

They take floats or NumPy arrays, and the simulation kernel compiles the very same functions. Equation
numbers are those of Maddahi et al., CDSR 2015, paper 181.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

import numpy as np

Quantity: TypeAlias = Any
"""A float, or a NumPy array of any shape that broadcasts with the other arguments."""

_Function = TypeVar("_Function", bound=Callable[..., object])

FAST_MATH = {"nsz", "arcp", "contract", "afn"}
"""Fast-math flags of compiled equations. NaN and infinity keep their meaning.

Reassociation is excluded: the compiler would order sums differently in the two halves of the lanes.
"""

EQUATIONS: list[Callable[..., object]] = []
"""All functions that compiled code may call; they are registered before a kernel is compiled."""


def equation(function: _Function) -> _Function:
    """Register a function for inlining into compiled code, and return it unchanged."""
    EQUATIONS.append(function)
    return function


@equation
def signed_root(value: Quantity) -> Quantity:
    """sgn(x) √abs(x), elementwise."""
    # The root of the absolute value is real for both signs, so no branch separates lanes of different sign.
    return np.copysign(np.sqrt(np.abs(value)), value)


@equation
def limited(value: Quantity, limit: Quantity) -> Quantity:
    """The value, limited to ±limit."""
    return np.minimum(np.maximum(value, -limit), limit)


@equation
def sine(turns: Quantity) -> Quantity:
    """sin(2πx) of a number of turns x, in operations that a compiler can vectorise.

    The turns are folded into a quarter of one, where the Taylor polynomial of degree 13 has an error below
    1e-9.
    """
    # The rest after the nearest whole number of turns, −½ … ½.
    part = turns - np.floor(turns + 0.5)
    # sin(π − x) = sin x folds the outer quarters back, so that the angle stays within 0 … π/2 rad.
    folded = (0.25 - np.abs(np.abs(part) - 0.25)) * (2.0 * np.pi)
    u = folded * folded
    # An odd series, so Horner's scheme runs in the square of the angle, from 1/13! down.
    series = 1.0 / 362880.0 - u * (1.0 / 39916800.0 - u * (1.0 / 6227020800.0))
    series = 1.0 - u * (1.0 / 6.0 - u * (1.0 / 120.0 - u * (1.0 / 5040.0 - u * series)))
    return np.copysign(folded * series, part)


NEGLIGIBLE = 1e-100
"""Absolute value below which a state counts as zero, in its SI unit.

An exponential decay ends in subnormal numbers (below 2e-308), which many processors handle about fifty times
more slowly. The margin covers products of states and small parameters.
"""


@equation
def settled(value: float) -> float:
    """The state, or zero if it is negligible; NaN stays NaN."""
    # A comparison with NaN is false, so NaN takes the second way.
    return 0.0 if abs(value) < NEGLIGIBLE else value
