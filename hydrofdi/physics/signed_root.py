"""Signed square root, as in turbulent orifice flow."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation


@equation
def signed_root(value: Quantity) -> Quantity:
    """sgn(x) √abs(x), elementwise."""
    return np.copysign(np.sqrt(np.abs(value)), value)
