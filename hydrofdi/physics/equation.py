"""The mark of a function that is both plain Python and part of the compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from numba.extending import register_jitable

Quantity: TypeAlias = Any
"""A float, or a NumPy array of any shape that broadcasts with the other arguments."""

_Function = TypeVar("_Function", bound=Callable[..., object])

FAST_MATH = {"nsz", "arcp", "contract", "afn"}
"""Liberties of the compiler within compiled equations. NaN and infinity keep their meaning. Sums keep their
order: where the compiler may reorder them, it does so differently in the two halves of the lanes."""


def equation(function: _Function) -> _Function:
    """Leave a function as it is for Python, and let compiled code inline it."""
    register: Callable[[_Function], _Function] = register_jitable(
        forceinline=True, fastmath=FAST_MATH, error_model="numpy"
    )
    return register(function)
