"""Lags of sensors, solved exactly for signals that are linear from sample to sample."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray


def first_order_response(signal: ArrayLike, interval: float, bandwidth: float) -> NDArray[np.float64]:
    """What a first-order sensor shows: y' = ω (u − y), at rest at the first sample.

    Parameters
    ----------
    signal : array_like, shape (n_time,)
        Samples of u, linear in between.
    interval : float
        Sampling interval [s].
    bandwidth : float
        Corner frequency ω/2π [Hz].

    Returns
    -------
    ndarray, shape (n_time,)
        In the unit of the signal.
    """
    return _lag(signal, 2.0 * math.pi * bandwidth * interval, (1.0, 1.0))


def second_order_response(
    signal: ArrayLike, interval: float, bandwidth: float, damping_ratio: float
) -> NDArray[np.float64]:
    """What a second-order sensor shows: y'' = ω² (u − y) − 2 ζ ω y', at rest at the first sample.

    Parameters
    ----------
    signal : array_like, shape (n_time,)
        Samples of u, linear in between.
    interval : float
        Sampling interval [s].
    bandwidth : float
        Undamped natural frequency ω/2π [Hz].
    damping_ratio : float
        ζ [-].

    Returns
    -------
    ndarray, shape (n_time,)
        In the unit of the signal.
    """
    return _lag(signal, 2.0 * math.pi * bandwidth * interval, (1.0, 2.0 * damping_ratio, 1.0))


def _lag(signal: ArrayLike, angle: float, denominator: tuple[float, ...]) -> NDArray[np.float64]:
    """Response of a lag whose natural frequency is 1, sampled at every `angle` [rad]."""
    from scipy.signal import lfilter

    samples = np.asarray(signal, dtype=float)
    deviation = lfilter(*_recursion(angle, denominator), samples - samples[0])
    return np.asarray(samples[0] + deviation, dtype=float)


@lru_cache(maxsize=1024)
def _recursion(
    angle: float, denominator: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients of input and output of the lag from sample to sample."""
    from scipy.signal import cont2discrete

    lag = np.array([1.0]), np.array(denominator)
    numerators, denominators, _ = cont2discrete(lag, angle, method="foh")
    return np.ravel(numerators), denominators
