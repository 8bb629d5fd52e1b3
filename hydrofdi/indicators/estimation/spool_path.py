"""Nominal spool position between samples: exact solution of a second-order lag under a held command."""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

from hydrofdi.physics.equation import equation, settled
from hydrofdi.physics.stability import second_order_eigenvalues

Array = NDArray[np.float64]


def spool_transition(frequency: float, damping_ratio: float, time: float) -> Array:
    """State transition matrix of the lag x'' = ω²(x_end − x) − 2ξω x'.

    Parameters
    ----------
    frequency : float
        ω [rad/s].
    damping_ratio : float
        ξ [-].
    time : float
        [s]

    Returns
    -------
    ndarray, shape (2, 2)
        e^(At) for x − x_end and velocity, by Sylvester's formula; ξ = 1 is shifted by 1e-6.
    """
    damping = damping_ratio if abs(damping_ratio - 1.0) > 1e-6 else 1.0 + 1e-6
    one, two = second_order_eigenvalues(frequency, damping)
    matrix = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])
    unit = np.eye(2)
    first, second = cmath.exp(one * time) / (one - two), cmath.exp(two * time) / (two - one)
    return np.ascontiguousarray((first * (matrix - two * unit) + second * (matrix - one * unit)).real)


@equation
def follow_command(spool: Array, target: float, transition: Array, path: Array) -> None:
    """Fill the spool positions over one sample under a held command.

    Parameters
    ----------
    spool : ndarray, shape (2,)
        Position and velocity at the start [mm, mm/s]; updated to the end.
    target : float
        Static spool position under the command [mm].
    transition : ndarray, shape (2, 2)
        `spool_transition` over one part of the path.
    path : ndarray, shape (n_part + 1,)
        Filled with positions [mm].
    """
    distance, velocity = spool[0] - target, spool[1]
    path[0] = spool[0]
    for i in range(1, path.size):
        ahead = transition[0, 0] * distance + transition[0, 1] * velocity
        velocity = settled(transition[1, 0] * distance + transition[1, 1] * velocity)
        distance = settled(ahead)
        path[i] = target + distance
    spool[0], spool[1] = target + distance, velocity


@equation
def between_samples(start: float, end: float, path: Array) -> None:
    """Fill a path with linearly interpolated positions between two samples [mm]."""
    for i in range(path.size):
        path[i] = start + (end - start) * (i / (path.size - 1))
