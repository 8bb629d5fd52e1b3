"""The odd square root of turbulent orifice flow."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from hydrofdi.physics.equation import Quantity, equation

Q = TypeVar("Q", bound=Quantity)


@equation
def signed_root(value: Q) -> Q:
    """sgn(x) √abs(x), element by element."""
    return np.copysign(np.sqrt(np.abs(value)), value)
