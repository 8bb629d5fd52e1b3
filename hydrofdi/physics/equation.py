"""Decorator for functions that run as plain Python and are inlined into compiled kernels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

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
