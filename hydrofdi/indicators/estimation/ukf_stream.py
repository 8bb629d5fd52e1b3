"""Unscented Kalman filters of streams: state between chunks, and estimates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.estimation.ekf_stream import FIRST_PARAMETER, N_MEASURED, Tuning, find_path
from hydrofdi.indicators.estimation.plant import N_STATE, Plant, actual, step_of
from hydrofdi.indicators.estimation.prediction import held_of, keep_moving, moving_of
from hydrofdi.indicators.estimation.square_root import (
    find_gain,
    inflate,
    measurement_update,
    take_triangle,
    triangularise,
)
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

Places = NDArray[np.int64]

GAUSSIAN = 2.0
"""b: weight of the centre, optimal for the fourth moments of a normal distribution."""


@equation
def place_points(mean: Array, root: Array, spread: float, places: Places, points: Array) -> None:
    """Fill sigma points in the rows `places`: the mean, and points at ±a √n times each column of S.

    One point per column, a is the spread, 0 < a² ≤ b.
    """
    n = places.size
    distance = spread * np.sqrt(n)
    for i in range(n):
        row = places[i]
        points[row, 0] = mean[i]
        for j in range(n):
            way = distance * root[i, j]
            points[row, 1 + j] = mean[i] + way
            points[row, 1 + n + j] = mean[i] - way


@equation
def gather_points(
    points: Array, places: Places, spread: float, noise: Array, mean: Array, root: Array, rows: Array
) -> None:
    """Compute mean and covariance root of propagated points plus process noise.

    `points` as from `place_points`, the centre first; `noise`: roots of the diagonal of Q; the root becomes
    lower triangular; `rows` (at least 3 n + 2, n) is scratch.
    """
    n = places.size
    weight = 1.0 / (2.0 * spread * spread * n)
    # The weight of the centre is split off, so that all weights under a root are positive.
    share, centre = np.sqrt(weight), np.sqrt(GAUSSIAN - spread * spread)
    last = 2 * n
    for i in range(n):
        way, place = 0.0, places[i]
        for j in range(last):
            difference = points[place, 1 + j] - points[place, 0]
            way += difference
            rows[j, i] = share * difference
        way *= weight
        mean[i] = points[place, 0] + way
        rows[last, i] = centre * way
        for j in range(n):
            rows[last + 1 + j, i] = 0.0
        rows[last + 1 + i, i] = noise[i]
    triangularise(rows, 3 * n + 1)
    take_triangle(rows, root)


class Estimated(NamedTuple):
    """Estimated states and their random walks.

    `places`: indices of the estimated states in ``STATES``, moving states first; all other states are zero;
    `walk`: standard deviations per sample; `spread` a of the sigma points, in √n standard deviations.
    """

    places: Places
    walk: Array
    spread: float


class Workspace(NamedTuple):
    """Arrays of a filter: estimate, gain, spool path and sigma points."""

    mean: Array
    root: Array
    gain: Array
    path: Array
    points: Array
    rows: Array

    @classmethod
    def of(cls, n: int, n_step: int) -> Workspace:
        """Allocate for n estimated states and `n_step` Runge-Kutta steps per sample."""
        shapes = (n,), (n, n), (n,), (2 * n_step + 1,), (N_STATE, 2 * n + 1), (3 * n + 2, n)
        return cls(*map(np.zeros, shapes))


@equation
def predict_unscented(
    step: float, supply: float, estimated: Estimated, plant: Plant, work: Workspace
) -> None:
    """Predict the estimate in a workspace over one sample, along its spool path; step [s], supply [MPa]."""
    points, path = work.points, work.path
    place_points(work.mean, work.root, estimated.spread, estimated.places, points)
    for i in range(path.size // 2):
        move(points, step, path[2 * i], path[2 * i + 1], path[2 * i + 2], supply, plant)
    gather_points(points, estimated.places, estimated.spread, estimated.walk, work.mean, work.root, work.rows)


@equation
def move(
    points: Array, step: float, start: float, middle: float, end: float, supply: float, plant: Plant
) -> None:
    """Advance points by one Runge-Kutta step."""
    for k in range(points.shape[1]):
        moving, held = moving_of(points[:, k]), held_of(points[:, k])
        moving = step_of(moving, step, start, middle, end, actual(held, supply, plant), plant)
        keep_moving(points[:, k], moving)


class Streams(NamedTuple):
    """State of the filters of all streams: means, NaN if a filter diverged, and roots S of covariances.

    `sums`: squared innovations over their variances, since the last estimate; `spool` and `held` as in
    `ekf_stream.Streams`.
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
        measurement_update(work.root, k, tuning.sensors[k] / variance, work.gain)
        for i in range(places.size):
            if is_open or places[i] < FIRST_PARAMETER:
                work.mean[i] += work.gain[i] * innovation
                work.gain[i] = 0.0
            work.gain[i] *= np.sqrt(variance)
        if not is_open:
            inflate(work.root, work.gain, work.rows)
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
    """Process a chunk of streams, which are updated in place, like `ekf_stream.follow`.

    Only estimated states, and the first column of `sums`, are filled.
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
