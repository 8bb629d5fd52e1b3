"""Lags of sensors, solved exactly for signals that are linear from sample to sample."""

from __future__ import annotations

import math
from collections.abc import Sequence

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
    return _lag(signal, 2.0 * math.pi * bandwidth * interval, [1.0, 1.0])


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
    return _lag(signal, 2.0 * math.pi * bandwidth * interval, [1.0, 2.0 * damping_ratio, 1.0])


def _lag(signal: ArrayLike, angle: float, denominator: Sequence[float]) -> NDArray[np.float64]:
    """Response of a lag whose natural frequency is 1, sampled at every `angle` [rad]."""
    from scipy.signal import cont2discrete, lfilter

    samples = np.asarray(signal, dtype=float)
    numerators, denominators, _ = cont2discrete((np.array([1.0]), np.array(denominator)), angle, method="foh")
    deviation = lfilter(np.ravel(numerators), denominators, samples - samples[0])
    return np.asarray(samples[0] + deviation, dtype=float)
