"""Information of outputs about states and parameters along a motion.

Krener and Ide, Measures of unobservability, IEEE Conference on Decision and Control (2009): singular values
of the finite-horizon Gramian, here scaled by the prior standard deviations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def finite_horizon_gramian(transitions: Array, outputs: Array, deviations: Array) -> Array:
    """Observability Gramian Σ_k Φ_kᵀ Cᵀ R⁻¹ C Φ_k with Φ_k = A_(k−1) … A_0, of the initial states.

    Parameters
    ----------
    transitions : ndarray, shape (n_step, n_state, n_state)
        A_k along the motion.
    outputs : ndarray, shape (n_output, n_state)
        C; outputs are taken at the start and after each step.
    deviations : ndarray, shape (n_output,)
        Standard deviations of the independent output noise: roots of the diagonal of R.

    Returns
    -------
    ndarray, shape (n_state, n_state)
        Not finite if the states overflow.
    """
    weighed = outputs / deviations[:, None]
    n_step, n_state = transitions.shape[:2]
    seen = np.empty((n_step + 1, *weighed.shape))
    carried = np.eye(n_state)
    seen[0] = weighed
    with np.errstate(over="ignore", invalid="ignore"):
        for step, transition in enumerate(transitions, 1):
            carried = transition @ carried
            seen[step] = weighed @ carried
        rows = seen.reshape(-1, n_state)
        return np.asarray(rows.T @ rows)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Singular values of a Gramian and their directions.

    Attributes
    ----------
    values : ndarray, shape (n,)
        In descending order.
    directions : ndarray, shape (n, n)
        One unit vector per row; its largest component is positive.
    """

    values: Array
    directions: Array

    @property
    def condition(self) -> float:
        """Ratio of largest to smallest singular value; infinite if the Gramian does not have full rank."""
        return float(self.values[0] / self.values[-1]) if self.values[-1] > 0.0 else math.inf


def spectrum(gramian: Array) -> Spectrum:
    """Singular values of a symmetric matrix; those indistinguishable from rounding are zero.

    Parameters
    ----------
    gramian : ndarray, shape (n, n)
    """
    values, vectors = np.linalg.eigh(gramian)
    directions = vectors.T[::-1]
    largest = np.take_along_axis(directions, np.abs(directions).argmax(axis=1)[:, None], axis=1)
    held = np.where(values > len(values) * np.finfo(float).eps * values[-1], values, 0.0)
    return Spectrum(held[::-1], directions * np.sign(largest))


def covariance_with_prior(gramian: Array) -> Array:
    """Posterior covariance (1 + G)⁻¹ of unknowns scaled by their prior standard deviations; G likewise."""
    return np.asarray(np.linalg.inv(np.eye(len(gramian)) + gramian))


def correlations(covariance: Array) -> Array:
    """Correlation matrix of a covariance matrix, shape (n, n)."""
    deviations = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(deviations, deviations))
