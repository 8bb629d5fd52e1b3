"""Recursive least squares in information form, with a prior that is not forgotten.

The moments of the equations are forgotten exponentially; the prior is added at each estimate. So the matrix
is symmetric and positive definite by construction, and unknowns without information return to their prior.

The errors of a window come from noise under the antisymmetric weight φ'. Two windows that overlap by half
share half of it with opposite signs, so their covariance is that of differences between independent block
errors.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.estimation.chamber_balance import COMPRESSIBILITY, N_UNKNOWN
from hydrofdi.physics.equation import equation
from hydrofdi.records import Array

_WIDTH = N_UNKNOWN + 1
"""Columns and target of an equation."""

EQUATIONS, DIFFERENCES = 0, 1
"""Indices of the moments: of the equations, and of their differences between adjacent windows."""


class RlsState(NamedTuple):
    """State between windows.

    `moments` (n_record, n_memory, n_kind, 2, _WIDTH, _WIDTH): lower triangles of sums of products, of
    `EQUATIONS` and `DIFFERENCES`; `counts` (n_record, n_memory): valid windows, with forgetting; `last`
    (n_record, n_kind, _WIDTH): the latest equations.
    """

    moments: Array
    counts: Array
    last: Array


class Scratch(NamedTuple):
    """Scratch memory of one estimate: arrays of N_UNKNOWN, the matrices square, and `row` (_WIDTH,)."""

    row: Array
    normal: Array
    factor: Array
    inverse: Array
    spread: Array
    covariance: Array
    right: Array
    values: Array


COMBINED, CONDITION, MISFIT = 2 * N_UNKNOWN, 2 * N_UNKNOWN + 1, 2 * N_UNKNOWN + 2
"""Indices after values and standard deviations: standard deviation of the combination, condition number,
misfit."""

N_ESTIMATE = 2 * N_UNKNOWN + 3
"""Number of values of an estimate."""


def new_state(n_record: int, n_memory: int, n_chamber: int) -> RlsState:
    """The state before the first window."""
    return RlsState(
        np.zeros((n_record, n_memory, n_chamber, 2, _WIDTH, _WIDTH)),
        np.zeros((n_record, n_memory)),
        np.zeros((n_record, n_chamber, _WIDTH)),
    )


def new_scratch() -> Scratch:
    """Scratch memory for `follow_windows`."""
    square, row = (N_UNKNOWN, N_UNKNOWN), N_UNKNOWN
    return Scratch(
        np.zeros(_WIDTH), np.zeros(square), np.zeros(square), np.zeros(square), np.zeros(square),
        np.zeros(square), np.zeros(row), np.zeros(row),
    )  # fmt: skip


@equation
def discount_and_add(moments: Any, decay: float, row: Any, share: float, last: Any) -> None:
    """Discount the moments, and add the products of a row minus `share` times the last row."""
    for i in range(_WIDTH):
        factor = row[i] - share * last[i]
        for j in range(i + 1):
            moments[i, j] = decay * moments[i, j] + factor * (row[j] - share * last[j])


@equation
def factorise(matrix: Any, factor: Any) -> None:
    """Cholesky factor of a symmetric matrix, from its lower triangle; NaN if it is not positive definite."""
    for j in range(N_UNKNOWN):
        for i in range(j, N_UNKNOWN):
            total = matrix[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = total / factor[j, j]
            else:
                # A root that is always real and a select: no branch stops vectorisation.
                root = np.sqrt(abs(total))
                factor[j, j] = root if total > 0.0 else math.nan


@equation
def invert(factor: Any, inverse: Any) -> None:
    """Inverse of the matrix with Cholesky factor L: invert L in place, then L⁻ᵀ L⁻¹."""
    # Forward substitution with the identity overwrites L column by column with its inverse.
    for j in range(N_UNKNOWN):
        factor[j, j] = 1.0 / factor[j, j]
        for i in range(j + 1, N_UNKNOWN):
            total = 0.0
            for k in range(j, i):
                total -= factor[i, k] * factor[k, j]
            factor[i, j] = total / factor[i, i]
    for i in range(N_UNKNOWN):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, N_UNKNOWN):
                total += factor[k, i] * factor[k, j]
            inverse[i, j] = inverse[j, i] = total


@equation
def residual_sum_of_squares(moments: Any, values: Any) -> float:
    """Sum of squared residuals of the equations with these moments, for given estimates."""
    total = moments[N_UNKNOWN, N_UNKNOWN]
    for i in range(N_UNKNOWN):
        product = -2.0 * moments[N_UNKNOWN, i] + moments[i, i] * values[i]
        for j in range(i):
            product += 2.0 * moments[i, j] * values[j]
        total += values[i] * product
    least: float = max(total, 0.0)
    return least


@equation
def misfit(moments: Any, count: float, values: Any) -> float:
    """RMS residual of the equations, in units of `error`."""
    total, n_kind = 0.0, moments.shape[0]
    for kind in range(n_kind):
        total += residual_sum_of_squares(moments[kind, EQUATIONS], values)
    size: float = np.sqrt(total / (n_kind * max(count, 1.0)))
    return size


@equation
def spread_of_products(moments: Any, count: float, last: Any, values: Any, spread: Any) -> None:
    """Covariance of the score (sum of equations times errors) including the prior; full symmetric matrix."""
    n_kind = moments.shape[0]
    for i in range(N_UNKNOWN):
        for j in range(i + 1):
            spread[i, j] = 1.0 if i == j else 0.0
    for kind in range(n_kind):
        # N_UNKNOWN windows with the stated error are added, so that few windows do not claim a small one.
        variance = (residual_sum_of_squares(moments[kind, EQUATIONS], values) + N_UNKNOWN) / (
            count + N_UNKNOWN
        )
        for i in range(N_UNKNOWN):
            for j in range(i + 1):
                # The newest equation has no successor: its half is added to the products of differences.
                ends = last[kind, i] * last[kind, j]
                spread[i, j] += 0.5 * variance * (moments[kind, DIFFERENCES, i, j] + ends)
    for i in range(N_UNKNOWN):
        for j in range(i):
            spread[j, i] = spread[i, j]


@equation
def sandwich(inverse: Any, spread: Any, product: Any, covariance: Any) -> None:
    """Covariance of the estimates: inverse · spread · inverse."""
    for i in range(N_UNKNOWN):
        for j in range(N_UNKNOWN):
            total = 0.0
            for k in range(N_UNKNOWN):
                total += inverse[i, k] * spread[k, j]
            product[i, j] = total
    for i in range(N_UNKNOWN):
        for j in range(i + 1):
            total = 0.0
            for k in range(N_UNKNOWN):
                total += product[i, k] * inverse[k, j]
            covariance[i, j] = covariance[j, i] = total


@equation
def condition_number(normal: Any, inverse: Any) -> float:
    """Root of the 1-norm condition number of the normal matrix after scaling to equal column norms."""
    largest, largest_inverse = 0.0, 0.0
    for i in range(N_UNKNOWN):
        total, total_inverse = 0.0, 0.0
        for j in range(N_UNKNOWN):
            size = np.sqrt(abs(normal[i, i] * normal[j, j]))
            entry = normal[i, j] if j <= i else normal[j, i]
            total += abs(entry) / size
            total_inverse += abs(inverse[i, j]) * size
        largest, largest_inverse = max(largest, total), max(largest_inverse, total_inverse)
    condition: float = np.sqrt(abs(largest * largest_inverse))
    return condition


@equation
def add_prior(moments: Any, prior: Any, s: Scratch) -> None:
    """Fill the normal equations from the moments of all kinds and the prior."""
    for i in range(N_UNKNOWN):
        s.right[i] = prior[i]
        for j in range(i + 1):
            s.normal[i, j] = 1.0 if i == j else 0.0
        for kind in range(moments.shape[0]):
            s.right[i] += moments[kind, EQUATIONS, N_UNKNOWN, i]
            for j in range(i + 1):
                s.normal[i, j] += moments[kind, EQUATIONS, i, j]


@equation
def compensate_noise_bias(noise: float, s: Scratch) -> float:
    """Correct the inverse for noise in the column of 1/β, and return the information that was only noise.

    Without this correction, 1/β is underestimated. The remaining information of the column is at least that
    of its prior. Bias compensation: Söderström, Errors-in-Variables Methods in System Identification (2018),
    chapter 7.
    """
    own = s.inverse[COMPRESSIBILITY, COMPRESSIBILITY]
    most = 1.0 / own - 1.0
    taken = noise if noise < most else most
    for i in range(N_UNKNOWN):
        s.values[i] = s.inverse[i, COMPRESSIBILITY]
    # Sherman-Morrison downdate: the inverse of (normal matrix minus `taken` at one place of its diagonal).
    share = taken / (1.0 - taken * own)
    for i in range(N_UNKNOWN):
        for j in range(N_UNKNOWN):
            s.inverse[i, j] += share * s.values[i] * s.values[j]
    return taken


@equation
def write_estimate(
    moments: Any, count: float, last: Any, noise: float, modulus: float, deviations: Any, combination: Any,
    s: Scratch, out: Any,
) -> None:  # fmt: skip
    """Write the maximum a posteriori estimate and its standard deviations."""
    invert(s.factor, s.inverse)
    if deviations[COMPRESSIBILITY] > 0.0:
        taken = compensate_noise_bias(count * noise, s)
        s.normal[COMPRESSIBILITY, COMPRESSIBILITY] -= taken
        s.right[COMPRESSIBILITY] += taken / (modulus * deviations[COMPRESSIBILITY])
    for i in range(N_UNKNOWN):
        total = 0.0
        for j in range(N_UNKNOWN):
            total += s.inverse[i, j] * s.right[j]
        s.values[i] = total
    spread_of_products(moments, count, last, s.values, s.spread)
    sandwich(s.inverse, s.spread, s.factor, s.covariance)
    variance = 0.0
    for i in range(N_UNKNOWN):
        out[i] = deviations[i] * s.values[i]
        out[N_UNKNOWN + i] = deviations[i] * np.sqrt(abs(s.covariance[i, i]))
        for j in range(N_UNKNOWN):
            factor = combination[i] * deviations[i] * combination[j] * deviations[j]
            variance += factor * s.covariance[i, j]
    out[COMBINED] = np.sqrt(abs(variance))
    out[CONDITION] = condition_number(s.normal, s.inverse)
    out[MISFIT] = misfit(moments, count, s.values)


@equation
def nan_unless_finite(out: Any) -> None:
    """Set all values of an estimate to NaN unless all are finite."""
    # 0 x is NaN if x is NaN or infinite: the sum spreads it without a branch.
    nothing = 0.0
    for i in range(N_ESTIMATE):
        nothing += 0.0 * out[i]
    for i in range(N_ESTIMATE):
        out[i] += nothing


@equation
def take_window(
    state: RlsState, r: int, columns: Any, targets: Any, counts: float, deviations: Any, error: float,
    decays: Any, row: Any,
) -> None:  # fmt: skip
    """Add the equations of a window to the moments of a record.

    For two chambers, these are their sum and difference.
    """
    n_kind = targets.shape[0]
    scale = np.sqrt(abs(1.0 / n_kind)) / error
    for kind in range(n_kind):
        sign, last = (1.0 if kind == 0 else -1.0), state.last[r, kind]
        for i in range(_WIDTH):
            row[i] = 0.0
        if counts > 0.0:
            for i in range(N_UNKNOWN):
                second = columns[1, i] if n_kind == 2 else 0.0
                row[i] = scale * deviations[i] * (columns[0, i] + sign * second)
            second = targets[1] if n_kind == 2 else 0.0
            row[N_UNKNOWN] = scale * (targets[0] + sign * second)
        for memory in range(decays.shape[0]):
            decay, moments = decays[memory], state.moments[r, memory, kind]
            discount_and_add(moments[EQUATIONS], decay, row, 0.0, last)
            discount_and_add(moments[DIFFERENCES], decay * decay, row, decay, last)
        for i in range(_WIDTH):
            last[i] = row[i]
    for memory in range(decays.shape[0]):
        state.counts[r, memory] = decays[memory] * state.counts[r, memory] + counts


@equation
def estimate(
    state: RlsState, r: int, memory: int, prior: Any, noise: float, modulus: float, deviations: Any,
    combination: Any, scratch: Scratch, out: Any,
) -> None:  # fmt: skip
    """Write an estimate of a record; NaN if it is not finite."""
    moments = state.moments[r, memory]
    add_prior(moments, prior, scratch)
    factorise(scratch.normal, scratch.factor)
    write_estimate(
        moments, state.counts[r, memory], state.last[r], noise, modulus, deviations, combination, scratch, out
    )
    nan_unless_finite(out)


@kernel
def follow_windows(
    columns: Array,
    targets: Array,
    counts: Array,
    due: NDArray[np.int64],
    priors: Array,
    deviations: Array,
    error: float,
    decays: Array,
    combination: Array,
    noise: Array,
    modulus: float,
    state: RlsState,
    scratch: Scratch,
    estimates: Array,
) -> None:
    """Process windows of streams, and fill the estimates (n_record, n_memory, n_instant, N_ESTIMATE).

    `columns` (n_record, n_window, n_chamber, N_UNKNOWN), `targets` [m³] and `counts` (n_record, n_window), 1
    if a window is valid, else 0; forgetting continues in both cases. `due` (n_instant,): number of these
    windows that are complete at each estimate. `priors` (n_record, n_instant, N_UNKNOWN): prior means over
    the prior `deviations` (N_UNKNOWN,), which are zero if known. `error`: standard deviation of a window's
    residual [m³]. `decays` (n_memory,): forgetting factor per window. `combination` (N_UNKNOWN,): factors of
    a linear combination whose deviation is computed, too. `noise` (n_record, n_instant): spurious information
    on 1/β from pressure noise, per window, relative to that of the prior. `modulus`: nominal β [Pa].

    The state is updated in place. Estimates are NaN once a window was not finite; they are not fed back, so
    they cannot diverge.
    """
    for r in range(estimates.shape[0]):
        n_taken = 0
        for instant in range(due.shape[0] + 1):
            n_due = due[instant] if instant < due.shape[0] else columns.shape[1]
            while n_taken < n_due:
                take_window(
                    state, r, columns[r, n_taken], targets[r, n_taken], counts[r, n_taken], deviations,
                    error, decays, scratch.row,
                )  # fmt: skip
                n_taken += 1
            if instant < due.shape[0]:
                for memory in range(decays.shape[0]):
                    estimate(
                        state, r, memory, priors[r, instant], noise[r, instant], modulus, deviations,
                        combination, scratch, estimates[r, memory, instant],
                    )  # fmt: skip
