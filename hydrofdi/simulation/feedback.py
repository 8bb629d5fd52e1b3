"""Position feedback of the controller, with sensor errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters


def steps_per_control(run: RunParameters) -> int:
    """Number of steps per sample of the controller."""
    return round(run.control.sample_time / run.record.step)


def reading_errors(
    run: RunParameters, steps: NDArray[np.int64], noise: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Error of the position before the converter, at the given steps.

    Parameters
    ----------
    run : RunParameters
    steps : ndarray of int, shape (n,)
        Step numbers, counted from the start of the record.
    noise : ndarray, shape (n_control,), optional
        Noise at each sample of the controller [m]; by default none.

    Returns
    -------
    ndarray, shape (n,)
        Bias, drift and noise [m]; zero if the controller reads the true position.
    """
    if not run.control.is_measured:
        return np.zeros(steps.shape)
    sensor = run.position_sensor
    errors = np.asarray(sensor.bias + sensor.drift * run.record.step * steps, dtype=float)
    return errors if noise is None else errors + noise[steps // steps_per_control(run)]
