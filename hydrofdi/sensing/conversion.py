"""Systematic sensor errors, and limited range and resolution of the converter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Value = Any
"""A float, or an array of any shape."""


def systematic_error(time: Value, bias: float, drift: float) -> Value:
    """Error from bias and drift of a sensor, in the unit of the signal.

    Parameters
    ----------
    time : array_like
        Time since the start of the record [s].
    bias : float
        In the unit of the signal.
    drift : float
        In the unit of the signal per second.
    """
    return bias + drift * np.asarray(time)


def saturated(signal: Value, lowest: float | None, highest: float | None) -> Value:
    """The signal limited to a range; None means no limit."""
    if lowest is None and highest is None:
        return signal
    return np.clip(signal, lowest, highest)


def quantised(signal: Value, lowest: float, resolution: float) -> Value:
    """The signal rounded to the nearest levels of a converter.

    Parameters
    ----------
    signal : array_like
    lowest : float
        The first level, in the unit of the signal.
    resolution : float
        Step between adjacent levels (LSB), in the unit of the signal.
    """
    return lowest + resolution * np.round((np.asarray(signal) - lowest) / resolution)


def quantisation_noise(resolution: float) -> float:
    """Standard deviation of quantisation noise, in the unit of the signal.

    It is modelled as white noise with uniform distribution over one level. This holds if the signal changes
    by more than one level between samples, or if its noise covers one level.

    Parameters
    ----------
    resolution : float
        Step between adjacent levels (LSB).
    """
    return resolution / math.sqrt(12.0)
