"""Unscented Kalman filters of streams: state between chunks, and estimates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.estimation.ekf import FIRST_PARAMETER, N_MEASURED
from hydrofdi.estimation.ekf_stream import Tuning, find_path
from hydrofdi.estimation.square_root import find_gain, grow, shrink
from hydrofdi.estimation.unscented import Estimated, Places, Workspace, predict_unscented
from hydrofdi.physics.equation import equation

Array = NDArray[np.float64]


class Streams(NamedTuple):
    """State of the filters of all streams.

    Attributes
    ----------
    mean : ndarray, shape (n_stream, n)
        Means of the n estimated states; NaN if the filter of a stream diverged.
    root : ndarray, shape (n_stream, n, n)
        Root S of their covariance S Sᵀ.
    sums : ndarray, shape (n_stream, 1)
        Sum of squared innovations over their variances, since the last estimate.
    spool : ndarray, shape (n_stream, 2)
        Position and velocity of the nominal spool [mm, mm/s].
    held : ndarray, shape (n_stream, 2)
        Drive of the spool [mm] and supply pressure [MPa] of the last sample.
    """

    mean: Array
    root: Array
    sums: Array
    spool: Array
    held: Array

    @classmethod
    def of(cls, n_stream: int, n: int) -> Streams:
        """State before the first sample."""
        shapes = (n,), (n, n), (1,), (2,), (2,)
        return cls(*(np.zeros((n_stream, *shape)) for shape in shapes))


@equation
def begin(measured: Array, prior: Array, places: Places, work: Workspace) -> None:
    """Initialise an estimate at its first sample: at rest at the measured position."""
    for i in range(places.size):
        work.mean[i] = measured[i] if i < N_MEASURED else 0.0
        for j in range(places.size):
            work.root[i, j] = np.sqrt(prior[places[i]]) if i == j else 0.0


@equation
def take_in(measured: Array, is_open: bool, tuning: Tuning, places: Places, work: Workspace) -> float:
    """Correct an estimate by the measurements of a sample; return the sum of normalised squared innovations.

    If the valve is closed, parameters are not updated, as in `ekf.find_gain`.
    """
    total = 0.0
    for k in range(N_MEASURED):
        innovation = measured[k] - work.mean[k]
        variance = find_gain(work.root, k, tuning.sensors[k], work.gain)
        shrink(work.root, k, tuning.sensors[k] / variance, work.gain)
        for i in range(places.size):
            if is_open or places[i] < FIRST_PARAMETER:
                work.mean[i] += work.gain[i] * innovation
                work.gain[i] = 0.0
            work.gain[i] *= np.sqrt(variance)
        if not is_open:
            grow(work.root, work.gain, work.rows)
        total += innovation * innovation / variance
    return total


@equation
def copy_in(streams: Streams, k: int, work: Workspace) -> None:
    """Copy the estimate of a stream into the workspace."""
    for i in range(work.mean.size):
        work.mean[i] = streams.mean[k, i]
        for j in range(work.mean.size):
            work.root[i, j] = streams.root[k, i, j]


@equation
def copy_out(streams: Streams, k: int, work: Workspace) -> None:
    """Copy the estimate from the workspace back to a stream."""
    for i in range(work.mean.size):
        streams.mean[k, i] = work.mean[i]
        for j in range(work.mean.size):
            streams.root[k, i, j] = work.root[i, j]


@equation
def state_variance(root: Array, i: int) -> float:
    """Variance of an estimated state."""
    total = 0.0
    for j in range(root.shape[1]):
        total += root[i, j] * root[i, j]
    return total


@equation
def give_up_unless_sound(limits: Array, places: Places, work: Workspace) -> None:
    """Set an estimate to NaN if it exceeds physical limits or its covariance is not finite."""
    sound = True
    for i in range(places.size):
        sound &= abs(work.mean[i]) <= limits[places[i]]
        sound &= state_variance(work.root, i) < np.inf
    if not sound:
        for i in range(places.size):
            work.mean[i] = np.nan


@kernel
def follow_unscented(
    streams: Streams, n_before: int, measured: Array, drive: Array, supply: Array, tuning: Tuning, every: int,
    means: Array, variances: Array, sums: Array, estimated: Estimated, work: Workspace,
) -> None:  # fmt: skip
    """Process a chunk of streams.

    Parameters
    ----------
    streams : Streams
        Updated in place.
    n_before, measured, drive, supply, tuning, every
        As for `ekf_stream.follow`.
    means, variances : ndarray, shape (n_stream, n_estimate, N_STATE)
        Filled with the estimates after the samples that `indicators.recursive.instants` returns, for
        estimated states only.
    sums : ndarray, shape (n_stream, n_estimate, at least 1)
        The first column is filled with the sum over the samples up to each estimate.
    estimated : Estimated
    work : Workspace
    """
    places = estimated.places
    for k in range(measured.shape[0]):
        n_estimate = 0
        copy_in(streams, k, work)
        for t in range(measured.shape[1]):
            if n_before + t == 0:
                begin(measured[k, t], tuning.prior, places, work)
                streams.spool[k, 0], streams.spool[k, 1] = drive[k, t], 0.0
            else:
                is_open = find_path(streams.spool[k], streams.held[k, 0], drive[k, t], tuning, work.path)
                predict_unscented(tuning.step, streams.held[k, 1], estimated, tuning.plant, work)
                streams.sums[k, 0] += take_in(measured[k, t], is_open, tuning, places, work)
                give_up_unless_sound(tuning.limits, places, work)
            streams.held[k, 0], streams.held[k, 1] = drive[k, t], supply[k, t]
            if (n_before + t + 1) % every == 0:
                for i in range(places.size):
                    means[k, n_estimate, places[i]] = work.mean[i]
                    variances[k, n_estimate, places[i]] = state_variance(work.root, i)
                sums[k, n_estimate, 0], streams.sums[k, 0] = streams.sums[k, 0], 0.0
                n_estimate += 1
        copy_out(streams, k, work)
