"""The odd square root of turbulent orifice flow."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation


@equation
def signed_root(value: Quantity) -> Quantity:
    """sgn(x) √abs(x), element by element."""
    return np.copysign(np.sqrt(np.abs(value)), value)
