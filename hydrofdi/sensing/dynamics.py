"""Lags of sensors and filters, solved exactly for signals that are linear between steps.

The input of a lag is u, its output y. The state is the error e = y − u, which is driven only by the slope of
u, so a constant input is reproduced exactly, however slow the lag.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.compiling import strictly_compiled
from hydrofdi.physics.equation import settled


class Lag(NamedTuple):
    """Coefficients of one step of a lag: error e, and rate r in units of the angular frequency.

    e_{k+1} = ee e_k + er r_k + eu (u_{k+1} − u_k), r_{k+1} = re e_k + rr r_k + ru (u_{k+1} − u_k)
    """

    ee: float
    er: float
    re: float
    rr: float
    eu: float
    ru: float


@lru_cache(maxsize=1024)
def first_order_lag(angle: float) -> Lag:
    """First-order lag y' = ω (u − y).

    Parameters
    ----------
    angle : float
        ω times the step [rad].
    """
    decay = math.exp(-angle)
    return Lag(decay, 0.0, 0.0, 0.0, math.expm1(-angle) / angle, 0.0)


@lru_cache(maxsize=1024)
def second_order_lag(angle: float, damping_ratio: float) -> Lag:
    """Second-order lag y'' = ω² (u − y) − 2 ζ ω y'.

    Parameters
    ----------
    angle : float
        ω times the step [rad].
    damping_ratio : float
        ζ [-].
    """
    from scipy.linalg import expm

    rates = np.array([[0.0, 1.0, -1.0 / angle], [-1.0, -2.0 * damping_ratio, 0.0], [0.0, 0.0, 0.0]])
    (ee, er, eu), (re, rr, ru), _ = expm(angle * rates).tolist()
    return Lag(ee, er, re, rr, eu, ru)


def butterworth_lags(angle: float, order: int) -> tuple[Lag, ...]:
    """Butterworth filter of even order, as second-order lags in series.

    Parameters
    ----------
    angle : float
        2π times the −3 dB corner frequency times the step [rad].
    order : int
        2, 4, ….
    """
    ratios = [math.sin(math.pi * k / (2 * order)) for k in range(1, order, 2)]
    return tuple(second_order_lag(angle, ratio) for ratio in ratios)


class LagLanes:
    """Lags in series for several signals in parallel; each starts at rest at the first value of its signal.

    Parameters
    ----------
    lags_of_lane : sequence of sequence of Lag, length n_lane
        Lags that each signal passes, in series; without lags a signal is unchanged.
    """

    def __init__(self, lags_of_lane: Sequence[Sequence[Lag]]) -> None:
        n_lag, n_lane = max(map(len, lags_of_lane), default=0), len(lags_of_lane)
        self._lags = np.zeros((n_lag, len(Lag._fields), n_lane))
        for lane, lags in enumerate(lags_of_lane):
            for place, lag in enumerate(lags):
                self._lags[place, :, lane] = lag
        self._states: NDArray[np.float64] | None = None

    def advance(self, signals: NDArray[np.float64]) -> None:
        """Replace the next values of the signals, shape (n_step, n_lane), by the outputs of the lags."""
        if self._states is None:
            self._states = np.zeros((len(self._lags), 3, signals.shape[1]))
            self._states[:, 0] = signals[0]
        for lag, state in zip(self._lags, self._states, strict=True):
            advance_lag(signals, lag, state)


@strictly_compiled
def advance_lag(signals: NDArray[np.float64], lag: NDArray[np.float64], state: NDArray[np.float64]) -> None:
    """Pass signals through a lag, in place.

    Parameters
    ----------
    signals : ndarray, shape (n_step, n_lane)
        Input; replaced by the output of the lag.
    lag : ndarray, shape (6, n_lane)
        `Lag` of each lane.
    state : ndarray, shape (3, n_lane)
        Last value, error and rate of each lane; updated in place.
    """
    for i in range(signals.shape[0]):
        for k in range(signals.shape[1]):
            value, error, rate = signals[i, k], state[1, k], state[2, k]
            change = value - state[0, k]
            state[0, k] = value
            state[1, k] = settled(lag[0, k] * error + lag[1, k] * rate + lag[4, k] * change)
            state[2, k] = settled(lag[2, k] * error + lag[3, k] * rate + lag[5, k] * change)
            signals[i, k] = value + state[1, k]
