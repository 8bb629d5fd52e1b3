"""Sampling with clock jitter."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydrofdi.compilation.compiling import strictly_compiled
from hydrofdi.config.sections.drive import RecordConfig
from hydrofdi.physics.equation import equation


def sampling_instants(
    time: NDArray[np.float64], jitter: float, generator: np.random.Generator
) -> NDArray[np.float64]:
    """Actual sampling instants of a clock with jitter [s].

    Parameters
    ----------
    time : ndarray, shape (n_time,)
        Nominal instants [s].
    jitter : float
        Standard deviation of the jitter [s].
    generator : Generator

    Returns
    -------
    ndarray, shape (n_time,)
        Normally distributed about the nominal instants, limited to the first and last of them [s].
    """
    instants = time + jitter * generator.standard_normal(time.size)
    return np.clip(instants, time[0], time[-1])


def interpolated_signal(signal: ArrayLike, time: ArrayLike, instants: ArrayLike) -> NDArray[np.float64]:
    """Values of a record between its samples, by cubic spline.

    Parameters
    ----------
    signal, time : array_like, shape (n_time,)
        The record and its instants [s]; at least four samples.
    instants : array_like
        Instants of the values [s].

    Returns
    -------
    ndarray, shape of `instants`
        In the unit of the signal.
    """
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
            self._first_nodes = np.clip(np.floor(places).astype(np.int64) - 1, 0, record.n_step - 4)
            self._offsets = places - self._first_nodes
            self._reach = 4 + int(np.abs(self._first_nodes - nominal).max())

    def sample(self, values: NDArray[np.float64], first_step: int, samples: NDArray[np.float64]) -> None:
        """Add the contribution of a block of steps to the samples; blocks must be contiguous.

        Parameters
        ----------
        values : ndarray, shape (n_step, n_lane)
        first_step : int
            Number of the first step of the block, counted from the start of the record.
        samples : ndarray, shape (n_lane, n_time)
            Zero before the first block; updated in place.
        """
        every = self._steps_per_sample
        if self._is_exact:
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
    """Add the contributions of the nodes within a block of steps to the samples.

    Parameters
    ----------
    values : ndarray, shape (n_step, n_lane)
    first_step : int
        Number of the first step of the block.
    first_nodes, offsets : ndarray, shape (n_lane, n_time)
        Step of the first of the four nodes, and the offset of the sample from it [steps].
    first, last : int
        Range of samples to update.
    samples : ndarray, shape (n_lane, n_time)
    """
    for lane in range(samples.shape[0]):
        for k in range(first, last):
            for node in range(4):
                step = first_nodes[lane, k] + node - first_step
                if 0 <= step < values.shape[0]:
                    samples[lane, k] += cubic_weight(node, offsets[lane, k]) * values[step, lane]
