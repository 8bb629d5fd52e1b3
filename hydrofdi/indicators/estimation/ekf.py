"""Extended Kalman filter: prediction and correction of one sample."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE
from hydrofdi.indicators.estimation.prediction import TANGENT_SHAPE, advance_with_transition
from hydrofdi.indicators.estimation.tuning import FIRST_PARAMETER, N_MEASURED, Tuning
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array


@equation
def spread(covariance: Array, transition: Array, walk: Array, rows: Array) -> None:
    """Propagate a covariance over one sample in place, by the derivatives of the moving states."""
    for m in range(N_MOVING):
        for j in range(N_STATE):
            rows[m, j] = 0.0
        for k in range(N_STATE):
            share = transition[m, k]
            for j in range(N_STATE):
                rows[m, j] += share * covariance[k, j]
    for m in range(N_MOVING):
        for j in range(N_MOVING, N_STATE):
            covariance[m, j] = covariance[j, m] = rows[m, j]
        for n in range(m + 1):
            total = 0.0
            for k in range(N_STATE):
                total += rows[m, k] * transition[n, k]
            covariance[m, n] = covariance[n, m] = total
    for j in range(N_STATE):
        covariance[j, j] += walk[j]


@equation
def find_gain(covariance: Array, place: int, total: float, is_trusted: bool, gain: Array) -> None:
    """Fill the Kalman gain of a measurement of one state, given the total innovation variance.

    If the measurement is not trusted, the gain of parameters is zero: only their variances are considered,
    Schmidt, Advances in Control Systems 3 (1966).
    """
    for j in range(N_STATE):
        gain[j] = covariance[place, j] / total
    if not is_trusted:
        for j in range(FIRST_PARAMETER, N_STATE):
            gain[j] = 0.0


@equation
def learn(covariance: Array, place: int, total: float, gain: Array, row: Array) -> None:
    """Update a covariance P for a measurement of state i with any gain K, in place.

    (1 − K e_iᵀ) P (1 − K e_iᵀ)ᵀ + r K Kᵀ = P − K p − (p − s K) Kᵀ with p = row i of P and s = P_ii + r.
    """
    for j in range(N_STATE):
        row[j] = covariance[place, j]
    for i in range(N_STATE):
        rest = row[i] - total * gain[i]
        for j in range(N_STATE):
            covariance[i, j] -= gain[i] * row[j] + rest * gain[j]


@equation
def make_symmetric(matrix: Array) -> None:
    """Symmetrise a square matrix in place: mean with its transpose."""
    for i in range(N_STATE):
        for j in range(i):
            matrix[i, j] = matrix[j, i] = 0.5 * (matrix[i, j] + matrix[j, i])


class Workspace(NamedTuple):
    """Scratch arrays of a filter: spool path, and those of a prediction and a correction."""

    path: Array
    transition: Array
    tangents: Array
    rows: Array
    gain: Array
    row: Array


def workspace(n_step: int) -> Workspace:
    """Allocate scratch arrays for `n_step` Runge-Kutta steps per sample."""
    moving = (N_MOVING, N_STATE)
    shapes = ((2 * n_step + 1,), moving, TANGENT_SHAPE, moving, (N_STATE,), (N_STATE,))
    return Workspace(*map(np.empty, shapes))


@equation
def predict(
    mean: Array, covariance: Array, signature: Array, supply: float, tuning: Tuning, work: Workspace
) -> None:
    """Predict a filter over one sample, along the spool path in its workspace; supply pressure [MPa]."""
    advance_with_transition(
        mean, work.path, tuning.step, supply, tuning.plant, work.transition, work.tangents
    )
    spread(covariance, work.transition, tuning.walk, work.rows)
    carry_signature(signature, work.transition)


@equation
def carry_signature(signature: Array, transition: Array) -> None:
    """Propagate the error of the filter with the plant, and add the effect of the leak over one sample."""
    leak = FIRST_PARAMETER
    first, second, third, fourth = (
        transition[0, leak], transition[1, leak], transition[2, leak], transition[3, leak],
    )  # fmt: skip
    for j in range(FIRST_PARAMETER):
        first += transition[0, j] * signature[j]
        second += transition[1, j] * signature[j]
        third += transition[2, j] * signature[j]
        fourth += transition[3, j] * signature[j]
    signature[0], signature[1], signature[2], signature[3] = first, second, third, fourth


@equation
def correct(
    mean: Array, covariance: Array, signature: Array, sums: Array, measured: Array, is_open: bool,
    tuning: Tuning, work: Workspace,
) -> None:  # fmt: skip
    """Correct a filter by the measurements of a sample, and accumulate the innovations."""
    for place in range(N_MEASURED):
        innovation = measured[place] - mean[place]
        total = covariance[place, place] + tuning.sensors[place]
        find_gain(covariance, place, total, is_open, work.gain)
        learn(covariance, place, total, work.gain, work.row)
        offset = signature[place]
        for j in range(N_STATE):
            mean[j] += work.gain[j] * innovation
            signature[j] -= work.gain[j] * offset
        sums[0] += innovation * innovation / total
        sums[1] += innovation * innovation if place < 2 else 0.0
        if is_open:
            sums[2] += offset * innovation / total
            sums[3] += offset * offset / total
    make_symmetric(covariance)
