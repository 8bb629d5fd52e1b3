"""Errors of a sensor, and the limited range and resolution of its converter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Value = Any
"""A float, or an array of any shape."""


def systematic_error(time: Value, bias: float, drift: float) -> Value:
    """Bias and drift of a sensor, in the unit of the signal.

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
    """A signal within a range; an end that is None is open."""
    if lowest is None and highest is None:
        return signal
    return np.clip(signal, lowest, highest)


def quantised(signal: Value, lowest: float, resolution: float) -> Value:
    """A signal on the nearest levels of a converter.

    Parameters
    ----------
    signal : array_like
    lowest : float
        The first level, in the unit of the signal.
    resolution : float
        Distance of neighbouring levels (LSB), in the unit of the signal.
    """
    return lowest + resolution * np.round((np.asarray(signal) - lowest) / resolution)


def quantisation_noise(resolution: float) -> float:
    """Standard deviation of quantisation noise, in the unit of the signal.

    It counts as white noise that is spread evenly over a level; this holds for a signal that moves by more
    than a level from sample to sample, or whose noise spans one.

    Parameters
    ----------
    resolution : float
        Distance of neighbouring levels (LSB).
    """
    return resolution / math.sqrt(12.0)
