"""Kalman filters of records, extended or unscented: state, and estimates."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.estimation.ekf import correct, predict
from hydrofdi.indicators.estimation.tuning import N_MEASURED, Tuning, find_path
from hydrofdi.indicators.estimation.ukf import correct_unscented, predict_unscented
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

N_SUM = 4
"""Number of sums over the samples since the last estimate: ν²/s; ν² of the pressures [MPa²]; dν/s and d²/s,
with d the signature: the change of innovation ν from a leak of 1 L/min since the start."""


class Streams(NamedTuple):
    """State of the filters of all streams.

    `mean` (n_stream, n_state) is NaN if the filter diverged; `covariance`, of an unscented filter its root;
    `sums` (n_stream, N_SUM), of an unscented filter the first; `spool`: position and velocity of the nominal
    spool [mm, mm/s]; `held`: drive of the spool [mm] and supply pressure [MPa] of the last sample.
    """

    mean: Array
    covariance: Array
    sums: Array
    spool: Array
    held: Array


@equation
def begin(mean: Array, covariance: Array, measured: Array, prior: Array) -> None:
    """Initialise a filter at its first sample: at rest at the measured position."""
    for i in range(mean.size):
        mean[i] = measured[i] if i < N_MEASURED else 0.0
        for j in range(mean.size):
            covariance[i, j] = prior[i] if i == j else 0.0


@equation
def variance(covariance: Array, spread: float | None, i: int) -> float:
    """Variance of an estimate from the covariance, or from its root."""
    total = covariance[i, i]
    if spread is not None:
        total = 0.0
        for j in range(covariance.shape[1]):
            total += covariance[i, j] * covariance[i, j]
    return total  # type: ignore[no-any-return]


@equation
def give_up_unless_sound(mean: Array, covariance: Array, limits: Array, spread: float | None) -> None:
    """Set an estimate to NaN if it exceeds physical limits, or a variance is negative or not finite."""
    sound = True
    for i in range(mean.size):
        sound &= abs(mean[i]) <= limits[i]
        sound &= 0.0 <= variance(covariance, spread, i) < np.inf
    if not sound:
        for i in range(mean.size):
            mean[i] = np.nan


@kernel
def follow(
    streams: Streams, measured: Array, drive: Array, supply: Array, tuning: Tuning, every: int,
    means: Array, variances: Array, sums: Array, signature: Array | None, spread: float | None, work: Any,
) -> None:  # fmt: skip
    """Process records from the zero state of their streams, which is updated in place.

    `measured` (n_stream, n_sample, N_MEASURED): P_1, P_2 [MPa] and x_p [mm]; `drive` (n_stream, n_sample):
    static spool position under the command, or the measured one [mm]; `supply` [MPa]. `means`, `variances`
    (n_stream, n_estimate, N_STATE) and `sums` (…, N_SUM) since the estimate before are filled after every
    `every` samples.

    Extended filters have a `signature` (n_stream, N_STATE), the error of the estimates per L/min of leakage
    that they do not model; unscented ones a `spread` of the sigma points, in √n standard deviations. The
    other is None; `work` is the workspace of the filter.
    """
    for k in range(measured.shape[0]):
        mean, covariance, own = streams.mean[k], streams.covariance[k], streams.sums[k]
        spool, held = streams.spool[k], streams.held[k]
        n_estimate = 0
        for t in range(measured.shape[1]):
            if t == 0:
                begin(mean, covariance, measured[k, t], tuning.prior)
                spool[0], spool[1] = drive[k, t], 0.0
            else:
                is_open = find_path(spool, held[0], drive[k, t], tuning, work.path)
                if signature is not None:
                    predict(mean, covariance, signature[k], held[1], tuning, work)
                    correct(mean, covariance, signature[k], own, measured[k, t], is_open, tuning, work)
                if spread is not None:
                    predict_unscented(mean, covariance, spread, held[1], tuning, work)
                    own[0] += correct_unscented(mean, covariance, measured[k, t], is_open, tuning, work)
                give_up_unless_sound(mean, covariance, tuning.limits, spread)
            held[0], held[1] = drive[k, t], supply[k, t]
            if (t + 1) % every == 0:
                for i in range(mean.size):
                    means[k, n_estimate, tuning.places[i]] = mean[i]
                    variances[k, n_estimate, tuning.places[i]] = variance(covariance, spread, i)
                for j in range(own.size):
                    sums[k, n_estimate, j], own[j] = own[j], 0.0
                n_estimate += 1
