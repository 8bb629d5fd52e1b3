"""Lags of sensors and filters, and sampling with clock jitter.

Lags are solved exactly for signals that are linear between steps. The input of a lag is u, its output y. The
state is the error e = y − u, which is driven only by the slope of u, so a constant input is reproduced
exactly, however slow the lag.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.compilation.compiling import strictly_compiled
from hydrofdi.config.sections.drive import RecordConfig
from hydrofdi.physics.equation import equation, settled


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
    """First-order lag y' = ω (u − y); the angle is ω times the step [rad]."""
    decay = math.exp(-angle)
    # (m1): expm1 keeps the digits of 1 − a if the step is short.
    return Lag(decay, 0.0, 0.0, 0.0, math.expm1(-angle) / angle, 0.0)


@lru_cache(maxsize=1024)
def second_order_lag(angle: float, damping_ratio: float) -> Lag:
    """Second-order lag y'' = ω² (u − y) − 2 ζ ω y'; the angle is ω times the step [rad]."""
    from scipy.linalg import expm

    # (m2): the third state is the rise of u over the step, which is constant.
    rates = np.array([[0.0, 1.0, -1.0 / angle], [-1.0, -2.0 * damping_ratio, 0.0], [0.0, 0.0, 0.0]])
    (ee, er, eu), (re, rr, ru), _ = expm(angle * rates).tolist()
    return Lag(ee, er, re, rr, eu, ru)


def butterworth_lags(angle: float, order: int) -> tuple[Lag, ...]:
    """Butterworth filter of even order, as second-order lags in series.

    The angle is 2π times the −3 dB corner frequency times the step [rad].
    """
    ratios = [math.sin(math.pi * k / (2 * order)) for k in range(1, order, 2)]  # (m10)
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
    """Replace signals (n_step, n_lane) by the output of a lag (6, n_lane), in place.

    The state (3, n_lane): last value, error and rate of each lane; updated in place.
    """
    for i in range(signals.shape[0]):
        for k in range(signals.shape[1]):
            value, error, rate = signals[i, k], state[1, k], state[2, k]
            change = value - state[0, k]
            state[0, k] = value
            # Zero instead of subnormal numbers, in which a constant signal would end.
            state[1, k] = settled(lag[0, k] * error + lag[1, k] * rate + lag[4, k] * change)
            state[2, k] = settled(lag[2, k] * error + lag[3, k] * rate + lag[5, k] * change)
            signals[i, k] = value + state[1, k]


def sampling_instants(
    time: NDArray[np.float64], jitter: float, generator: np.random.Generator
) -> NDArray[np.float64]:
    """Actual sampling instants of a clock with jitter [s]: normally distributed about the nominal ones.

    They are limited to the first and last of those.
    """
    instants = time + jitter * generator.standard_normal(time.size)  # (m3)
    return np.clip(instants, time[0], time[-1])


def interpolated_signal(signal: ArrayLike, time: ArrayLike, instants: ArrayLike) -> NDArray[np.float64]:
    """Values of a record of at least four samples at some instants, by cubic spline."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.asarray(time), np.asarray(signal))(np.asarray(instants)), dtype=float)


class Clocks:
    """Clocks that sample several signals in parallel, from their values at every step of the solver.

    Between steps, a signal is the cubic polynomial through the four nearest steps.

    Parameters
    ----------
    record : RecordConfig
        Solver step and sampling of the record.
    deviations : ndarray, shape (n_lane, n_time)
        Deviation of each sampling instant from nominal, positive if late [s].
    """

    def __init__(self, record: RecordConfig, deviations: NDArray[np.float64]) -> None:
        self._steps_per_sample, self._n_time = record.steps_per_sample, record.n_sample
        self._is_exact = not deviations.any()
        if not self._is_exact:
            nominal = record.steps_per_sample * np.arange(record.n_sample)
            places = nominal + deviations / record.step
            # Two nodes on each side of the instant, except at the ends of the record.
            self._first_nodes = np.clip(np.floor(places).astype(np.int64) - 1, 0, record.n_step - 4)
            self._offsets = places - self._first_nodes
            # How far the nodes of a sample lie from its nominal step, perhaps in another block.
            self._reach = 4 + int(np.abs(self._first_nodes - nominal).max())

    def sample(self, values: NDArray[np.float64], first_step: int, samples: NDArray[np.float64]) -> None:
        """Add the contribution of a block of steps (n_step, n_lane) to the samples (n_lane, n_time).

        Blocks must be contiguous; the samples are zero before the first.
        """
        every = self._steps_per_sample
        if self._is_exact:
            # From the first step of the block that is a sample.
            picked = values[-first_step % every :: every].T
            samples[:, -(-first_step // every) :][:, : picked.shape[1]] = picked
            return
        first = max(0, (first_step - self._reach) // every)
        last = min(self._n_time, (first_step + len(values) + self._reach) // every + 1)
        add_nodes(values, first_step, self._first_nodes, self._offsets, first, last, samples)


@equation
def cubic_weight(node: int, place: float) -> float:
    """Weight of node 0 … 3 in the cubic polynomial through the values at four nodes."""
    weight = 1.0
    for other in range(4):
        if other != node:
            # Lagrange's form: 1 at its own node, 0 at the others.
            weight *= (place - other) / (node - other)
    return weight


@strictly_compiled
def add_nodes(
    values: NDArray[np.float64],
    first_step: int,
    first_nodes: NDArray[np.int64],
    offsets: NDArray[np.float64],
    first: int,
    last: int,
    samples: NDArray[np.float64],
) -> None:
    """Add the contributions of the nodes within a block of steps (n_step, n_lane) to the samples.

    `first_nodes` and `offsets` (n_lane, n_time): step of the first of the four nodes, and offset of the
    sample from it [steps]; samples from `first` to `last` are updated.
    """
    for lane in range(samples.shape[0]):
        for k in range(first, last):
            for node in range(4):
                step = first_nodes[lane, k] + node - first_step
                if 0 <= step < values.shape[0]:
                    samples[lane, k] += cubic_weight(node, offsets[lane, k]) * values[step, lane]
