"""A controller whose voltage is at its limit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.shown_values import shown_value

_MUCH = 0.1
"""Share of the samples at the limit from which on the limit decides the motion."""

_SLACK = 1e-3
"""Relative distance from the limit that still counts as being there."""


def saturation_warning(run: RunParameters, voltage: NDArray[np.float64]) -> str:
    """A sentence if the controller is at its limit for much of a record; else empty.

    Parameters
    ----------
    run : RunParameters
    voltage : ndarray, shape (n_time,)
        Input voltage [V].
    """
    limit = run.control.voltage_limit
    share = float(np.mean(np.abs(voltage) >= (1.0 - _SLACK) * limit))
    if not run.control.is_closed or share < _MUCH:
        return ""
    return (
        f"the controller is at control.voltage_limit = {shown_value('control.voltage_limit', limit)} in"
        f" {100.0 * share:.0f} % of the samples; set it to the range of your valve, or lower"
        " control.amplitude or control.proportional_gain"
    )
