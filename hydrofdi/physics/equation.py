"""The mark of a function that is both plain Python and part of the compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

Quantity: TypeAlias = Any
"""A float, or a NumPy array of any shape that broadcasts with the other arguments."""

_Function = TypeVar("_Function", bound=Callable[..., object])

FAST_MATH = {"nsz", "arcp", "contract", "afn"}
"""Liberties of the compiler within compiled equations. NaN and infinity keep their meaning. Sums keep their
order: where the compiler may reorder them, it does so differently in the two halves of the lanes."""

EQUATIONS: list[Callable[..., object]] = []
"""All functions that compiled code may call; the compiler learns of them before it compiles a kernel."""


def equation(function: _Function) -> _Function:
    """Leave a function as it is for Python, and let compiled code inline it."""
    EQUATIONS.append(function)
    return function
