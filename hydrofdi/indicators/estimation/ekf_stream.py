"""Extended Kalman filters of streams: state between chunks, and estimates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.estimation.plant import N_MOVING, N_STATE, Plant, between_samples, follow_command
from hydrofdi.indicators.estimation.prediction import TANGENT_SHAPE, advance_with_transition
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

N_MEASURED = 3
"""Number of measurements: P_1, P_2 and x_p, the first of the moving states."""

FIRST_PARAMETER = 5
"""Index of the first state that is neither motion nor force."""


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


@equation
def is_sound(mean: Array, covariance: Array, limits: Array) -> bool:
    """Whether all estimates are within physical limits and no variance is negative; false for NaN."""
    sound = True
    for j in range(N_STATE):
        sound &= abs(mean[j]) <= limits[j]
        sound &= 0.0 <= covariance[j, j] < np.inf
    return sound


LEAKAGE = 5
"""Index of the leakage among the states."""

N_SUM = 4
"""Number of sums over the samples since the last estimate: ν²/s; ν² of the pressures [MPa²]; dν/s and d²/s,
with d the signature: the change of innovation ν from a leak of 1 L/min since the start."""


class Streams(NamedTuple):
    """State of the filters of all streams.

    `mean` (n_stream, N_STATE) is NaN if the filter diverged; `covariance`; `signature` (n_stream, N_STATE):
    error of the estimates per L/min of leakage that the filter does not model; `sums` (n_stream, N_SUM);
    `spool`: position and velocity of the nominal spool [mm, mm/s]; `held`: drive of the spool [mm] and supply
    pressure [MPa] of the last sample.
    """

    mean: Array
    covariance: Array
    signature: Array
    sums: Array
    spool: Array
    held: Array


class Tuning(NamedTuple):
    """Known parameters of plant and sensors.

    `step` of Runge-Kutta [s]; `spool_transition` (2, 2) over half a step; whether the spool `follows_command`
    or is measured; initial variance `prior` of each state and process noise `walk` per sample; variances of
    the `sensors` [MPa², MPa², mm²]; `limits` of each estimate. Parameters are not updated while the spool is
    within `null_zone` of its centre, or travels more than `largest_travel` within a sample [mm].
    """

    plant: Plant
    step: float
    spool_transition: Array
    follows_command: bool
    prior: Array
    walk: Array
    sensors: Array
    limits: Array
    null_zone: float
    largest_travel: float


class Workspace(NamedTuple):
    """Scratch arrays of a filter."""

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
def begin(streams: Streams, k: int, measured: Array, tuning: Tuning) -> None:
    """Initialise a filter at its first sample: at rest at the measured position, spool at its command."""
    for i in range(N_STATE):
        streams.mean[k, i] = measured[i] if i < N_MEASURED else 0.0
        for j in range(N_STATE):
            streams.covariance[k, i, j] = tuning.prior[i] if i == j else 0.0


@equation
def predict_sample(streams: Streams, k: int, drive: float, tuning: Tuning, work: Workspace) -> bool:
    """Predict a filter to the next sample; return whether parameters may be updated there."""
    is_open = find_path(streams.spool[k], streams.held[k, 0], drive, tuning, work.path)
    advance_with_transition(
        streams.mean[k],
        work.path,
        tuning.step,
        streams.held[k, 1],
        tuning.plant,
        work.transition,
        work.tangents,
    )
    spread(streams.covariance[k], work.transition, tuning.walk, work.rows)
    carry_signature(streams.signature[k], work.transition)
    return is_open


@equation
def find_path(spool: Array, before: float, drive: float, tuning: Tuning, path: Array) -> bool:
    """Fill the path of a spool to the next sample; return whether the valve stays open and nearly at rest."""
    if tuning.follows_command:
        follow_command(spool, before, tuning.spool_transition, path)
    else:
        between_samples(before, drive, path)
    least, most = min(path[0], path[-1]), max(path[0], path[-1])
    is_open: bool = least > tuning.null_zone or most < -tuning.null_zone
    return is_open and most - least <= tuning.largest_travel


@equation
def carry_signature(signature: Array, transition: Array) -> None:
    """Propagate the error of the filter with the plant, and add the effect of the leak over one sample."""
    first, second, third, fourth = (
        transition[0, LEAKAGE], transition[1, LEAKAGE], transition[2, LEAKAGE], transition[3, LEAKAGE],
    )  # fmt: skip
    for j in range(LEAKAGE):
        first += transition[0, j] * signature[j]
        second += transition[1, j] * signature[j]
        third += transition[2, j] * signature[j]
        fourth += transition[3, j] * signature[j]
    signature[0], signature[1], signature[2], signature[3] = first, second, third, fourth


@equation
def take_in(
    streams: Streams, k: int, measured: Array, is_open: bool, tuning: Tuning, work: Workspace
) -> None:
    """Correct a filter by the measurements of a sample, and accumulate the innovations."""
    mean, covariance, signature, sums = (
        streams.mean[k], streams.covariance[k], streams.signature[k], streams.sums[k],
    )  # fmt: skip
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
    if not is_sound(mean, covariance, tuning.limits):
        for j in range(N_STATE):
            mean[j] = np.nan


@kernel
def follow(
    streams: Streams, n_before: int, measured: Array, drive: Array, supply: Array, tuning: Tuning, every: int,
    means: Array, variances: Array, sums: Array, work: Workspace,
) -> None:  # fmt: skip
    """Process a chunk of streams, which are updated in place.

    `measured` (n_stream, n_sample, N_MEASURED): P_1, P_2 [MPa] and x_p [mm]; `drive` (n_stream, n_sample):
    static spool position under the command, or the measured one [mm]; `supply` [MPa]. `means`, `variances`
    (n_stream, n_estimate, N_STATE) and `sums` (…, N_SUM) since the estimate before are filled after every
    `every` samples, at those that `indicators.recursive.instants` returns.
    """
    for k in range(measured.shape[0]):
        n_estimate = 0
        for t in range(measured.shape[1]):
            if n_before + t == 0:
                begin(streams, k, measured[k, t], tuning)
                streams.spool[k, 0], streams.spool[k, 1] = drive[k, t], 0.0
            else:
                is_open = predict_sample(streams, k, drive[k, t], tuning, work)
                take_in(streams, k, measured[k, t], is_open, tuning, work)
            streams.held[k, 0], streams.held[k, 1] = drive[k, t], supply[k, t]
            if (n_before + t + 1) % every == 0:
                for j in range(N_STATE):
                    means[k, n_estimate, j] = streams.mean[k, j]
                    variances[k, n_estimate, j] = streams.covariance[k, j, j]
                for j in range(N_SUM):
                    sums[k, n_estimate, j], streams.sums[k, j] = streams.sums[k, j], 0.0
                n_estimate += 1
