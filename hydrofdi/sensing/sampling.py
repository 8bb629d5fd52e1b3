"""Sampling at instants that are not quite the nominal ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def sampling_instants(
    time: NDArray[np.float64], jitter: float, generator: np.random.Generator
) -> NDArray[np.float64]:
    """The instants at which a clock really samples.

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        Nominal instants [s].
    jitter : float
        Standard deviation about these [s].
    generator : Generator

    Returns
    -------
    ndarray, shape (n_time,)
        Normally distributed about the nominal ones, none before the first or after the last of these [s].
    """
    instants = time + jitter * generator.standard_normal(time.size)
    return np.clip(instants, time[0], time[-1])


def interpolated_signal(signal: ArrayLike, time: ArrayLike, instants: ArrayLike) -> NDArray[np.float64]:
    """A record between its samples, on its cubic spline.

    Parameters
    ----------
    signal, time : array_like, shape (n_time,)
        The record and its instants [s]; at least four samples.
    instants : array_like
        Where it is wanted [s].

    Returns
    -------
    ndarray, shape of `instants`
        In the unit of the signal.
    """
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.asarray(time), np.asarray(signal))(np.asarray(instants)), dtype=float)
