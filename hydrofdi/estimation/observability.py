"""Information of outputs along a motion about states and parameters.

Krener and Ide, Measures of unobservability, IEEE Conference on Decision and Control (2009): the singular
values of the Gramian of a finite horizon, here in units of what is known beforehand.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def finite_horizon_gramian(transitions: Array, outputs: Array, deviations: Array) -> Array:
    """Observability Gramian Σ_k Φ_kᵀ Cᵀ R⁻¹ C Φ_k with Φ_k = A_(k−1) … A_0, of the states at the start.

    Parameters
    ----------
    transitions : ndarray, shape (n_step, n_state, n_state)
        A_k along the motion.
    outputs : ndarray, shape (n_output, n_state)
        C; outputs are taken at the start and behind each step.
    deviations : ndarray, shape (n_output,)
        Roots of R, of independent noise.

    Returns
    -------
    ndarray, shape (n_state, n_state)
        Not finite where the states grow beyond all numbers.
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
    """Singular values of a Gramian, and the directions that they belong to.

    Attributes
    ----------
    values : ndarray, shape (n,)
        The largest first.
    directions : ndarray, shape (n, n)
        A row each, of length one; its largest part is positive.
    """

    values: Array
    directions: Array

    @property
    def condition(self) -> float:
        """The largest over the smallest; infinite if the Gramian has not the full rank."""
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
    """Covariance of unknowns in units of their deviations beforehand: (1 + G)⁻¹, G in the same units."""
    return np.asarray(np.linalg.inv(np.eye(len(gramian)) + gramian))


def correlations(covariance: Array) -> Array:
    """Correlations of a covariance, shape (n, n)."""
    deviations = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(deviations, deviations))
