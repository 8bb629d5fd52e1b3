"""Decorator for functions that run as plain Python and are inlined into compiled kernels."""

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
    return np.copysign(np.sqrt(np.abs(value)), value)


@equation
def limited(value: float, limit: float) -> float:
    """The value, limited to ±limit."""
    return min(max(value, -limit), limit)


NEGLIGIBLE = 1e-100
"""Absolute value below which a state counts as zero, in its SI unit.

An exponential decay ends in subnormal numbers (below 2e-308), which many processors handle about fifty times
more slowly. The margin covers products of states and small parameters.
"""


@equation
def settled(value: float) -> float:
    """The state, or zero if it is negligible; NaN stays NaN."""
    return 0.0 if abs(value) < NEGLIGIBLE else value
