"""The mark of a function that is both plain Python and part of the compiled kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

Quantity = float | NDArray[np.float64]
"""A scalar, or an array of any shape that broadcasts with the other arguments."""

_Function = TypeVar("_Function", bound=Callable[..., object])


def equation(function: _Function) -> _Function:
    """Leave a function as it is for Python, and let compiled code inline it."""
    return cast(_Function, register_jitable(forceinline=True, fastmath={"nsz","arcp","contract","reassoc","afn"}, error_model="numpy")(function))
