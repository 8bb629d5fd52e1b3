"""Maximum a posteriori estimates of the unknowns of a chamber balance, in information form.

The moments of the equations are forgotten exponentially; the prior is added at each estimate. So the matrix
is symmetric and positive definite by construction, and unknowns without information return to their prior.

Estimates weight the record with an error that agrees with its misfit. An error of the model is not noise:
it is alike in neighbouring windows, so in the stated deviations a misfit beyond the error counts
`CORRELATED` times.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.estimation.chamber_balance import COMPRESSIBILITY, N_UNKNOWN, UNKNOWNS
from hydrofdi.physics import equation
from hydrofdi.records import Array

_WIDTH = N_UNKNOWN + 1
"""Columns and target of an equation."""

_LEAK, _CLEARANCE = UNKNOWNS.index("internal_coefficient"), UNKNOWNS.index("clearance")

CORRELATED = 50.0
"""Number of windows that share an error of the model: about 1.6 s at 500 Hz."""

N_FIT = 4
"""Largest number of fits until error and misfit agree."""

WIDER = 3.0
"""Deviations from the data sheet that the stated deviations allow, over the prior ones. Priors are narrow so
that the record decides; machines of one type differ more."""

_NOT_LAMINAR = 0.05
"""Relative standard deviation of the flow through the clearance from one that is proportional to ΔP."""

LAW = 0.3
"""Relative standard deviation of a mean flow whose law and place on the stroke are unknown."""


class RlsState(NamedTuple):
    """State between windows.

    `moments` (n_record, n_chamber, _WIDTH, _WIDTH): lower triangles of sums of products; `counts`
    (n_record,): valid windows, with forgetting; `pressures` (n_record, 3): integrals over all windows, with
    forgetting, of 1, √|ΔP| and |ΔP|.
    """

    moments: Array
    counts: Array
    pressures: Array


class Assumptions(NamedTuple):
    """What is known before the first window.

    Prior `deviations` (N_UNKNOWN,), zero if known; standard deviation `error` of a window's residual [m³];
    `reference`: ΔP at which the flow for any law is stated [Pa]; `half_time`: half the length of a window
    [s]; `modulus`: nominal β [Pa].
    """

    deviations: Array
    error: float
    reference: float
    half_time: float
    modulus: float


class Scratch(NamedTuple):
    """Scratch memory of one estimate: `row` (_WIDTH,), `moments` square, and arrays and square matrices
    of N_UNKNOWN."""

    row: Array
    moments: Array
    normal: Array
    factor: Array
    inverse: Array
    right: Array
    values: Array


CONDITION, MISFIT, COMBINED, COMBINED_ERROR, MEAN, MEAN_ERROR, UNDETERMINED, DISAGREEMENT = range(
    2 * N_UNKNOWN, 2 * N_UNKNOWN + 8
)
"""Indices after values and standard deviations: condition number, misfit, flow for any law at the reference
pressure and its standard deviation [m³/s], the same in the mean, the variance of K_i over that of its prior,
and the difference between the K_i of each chamber alone over its standard deviation."""

N_ESTIMATE = 2 * N_UNKNOWN + 8
"""Number of values of an estimate."""


def new_state(n_record: int, n_chamber: int) -> RlsState:
    """The state before the first window."""
    shapes = (n_record, n_chamber, _WIDTH, _WIDTH), (n_record,), (n_record, 3)
    return RlsState(*map(np.zeros, shapes))


def new_scratch() -> Scratch:
    """Scratch memory for `follow_windows`."""
    square, row = (N_UNKNOWN, N_UNKNOWN), (N_UNKNOWN,)
    return Scratch(*map(np.zeros, ((_WIDTH,), (_WIDTH, _WIDTH), square, square, square, row, row)))


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
def add_prior(moments: Any, prior: Any, variance: float, wider: float, s: Scratch) -> None:
    """Fill the normal equations from the moments, for a variance of their errors, and the prior.

    `wider`: factor on the prior deviation of the clearance.
    """
    for i in range(N_UNKNOWN):
        s.right[i] = prior[i] + moments[N_UNKNOWN, i] / variance
        for j in range(i + 1):
            s.normal[i, j] = (1.0 if i == j else 0.0) + moments[i, j] / variance
    s.normal[_CLEARANCE, _CLEARANCE] -= 1.0 - 1.0 / (wider * wider)


@equation
def set_covariance(prior: Any, variance: float, wider: float, s: Scratch) -> None:
    """Fill normal equations and their inverse, for a variance of the errors of the moments."""
    add_prior(s.moments, prior, variance, wider, s)
    factorise(s.normal, s.factor)
    invert(s.factor, s.inverse)


@equation
def solve(known: Assumptions, s: Scratch) -> None:
    """Fill the estimates; the clearance and the compressibility are not negative."""
    deviation = known.deviations[COMPRESSIBILITY]
    for i in range(N_UNKNOWN):
        total = 0.0
        for j in range(N_UNKNOWN):
            total += s.inverse[i, j] * s.right[j]
        s.values[i] = total
    stiffest = -1.0 / (known.modulus * deviation) if deviation > 0.0 else 0.0
    for index, least in ((COMPRESSIBILITY, stiffest), (_CLEARANCE, 0.0)):
        # The estimate under the condition of its least value, from the unconditional one.
        excess = min(s.values[index] - least, 0.0) / s.inverse[index, index]
        for i in range(N_UNKNOWN):
            s.values[i] -= excess * s.inverse[i, index]


@equation
def fit(
    moments: Any, first: int, last: int, count: float, prior: Any, wider: float, known: Assumptions,
    s: Scratch,
) -> tuple[float, float]:  # fmt: skip
    """Fill estimates and inverse from some chambers.

    Returns the misfit, and the variance of the leak over that of its prior if the model is right.
    """
    for i in range(_WIDTH):
        for j in range(i + 1):
            s.moments[i, j] = moments[first, i, j]
            for chamber in range(first + 1, last):
                s.moments[i, j] += moments[chamber, i, j]
    variance, square = 1.0, 0.0
    for _ in range(N_FIT):
        set_covariance(prior, variance, wider, s)
        solve(known, s)
        square = residual_sum_of_squares(s.moments, s.values) / ((last - first) * max(count, 1.0))
        if not square > variance:
            break
        variance = square
    share = s.inverse[_LEAK, _LEAK]
    if square > 1.0:
        variance = 1.0 + CORRELATED * (square - 1.0)
        set_covariance(prior, variance, wider, s)
    return np.sqrt(square), share


@equation
def covariance_of(i: int, j: int, inverse: Any) -> float:
    """Covariance of two estimates if the machine differs from its data sheet by more than the priors."""
    # C (N + κ² I) C = C + (κ² − 1) C², C = (N + I)⁻¹, κ² the variance of the unknowns over the prior one.
    total: float = inverse[i, j]
    for k in range(N_UNKNOWN):
        if k not in (_LEAK, _CLEARANCE):
            total += (WIDER * WIDER - 1.0) * inverse[i, k] * inverse[j, k]
    return total


@equation
def combined_variance(of_leak: float, of_clearance: float, inverse: Any) -> float:
    """Variance of a combination of the estimates of leak and clearance, with factors in prior deviations."""
    both = 2.0 * of_leak * of_clearance * covariance_of(_LEAK, _CLEARANCE, inverse)
    alone = of_leak * of_leak * covariance_of(_LEAK, _LEAK, inverse)
    total: float = alone + both + of_clearance * of_clearance * covariance_of(_CLEARANCE, _CLEARANCE, inverse)
    return total


@equation
def write_estimate(reference: float, deviations: Any, s: Scratch, out: Any) -> None:
    """Write the estimates and their standard deviations."""
    for i in range(N_UNKNOWN):
        out[i] = deviations[i] * s.values[i]
        out[N_UNKNOWN + i] = deviations[i] * np.sqrt(abs(s.inverse[i, i]))
    # The flow of the clearance is not exactly laminar: K_i takes up the rest.
    rest = _NOT_LAMINAR * s.values[_CLEARANCE] * deviations[_CLEARANCE] * np.sqrt(reference)
    known = deviations[_LEAK] * deviations[_LEAK] * covariance_of(_LEAK, _LEAK, s.inverse)
    out[N_UNKNOWN + _LEAK] = np.sqrt(abs(known + rest * rest))
    out[CONDITION] = condition_number(s.normal, s.inverse)


@equation
def write_flow(reference: float, pressures: Any, deviations: Any, s: Scratch, out: Any) -> None:
    """Write the flow across piston and closed valve, at the reference pressure and in the mean."""
    leak, clearance = deviations[_LEAK], deviations[_CLEARANCE]
    at_root, at_reference = leak * np.sqrt(reference), clearance * reference
    out[COMBINED] = at_root * s.values[_LEAK] + at_reference * s.values[_CLEARANCE]
    out[COMBINED_ERROR] = np.sqrt(abs(combined_variance(at_root, at_reference, s.inverse)))
    root, difference = leak * pressures[1] / pressures[0], clearance * pressures[2] / pressures[0]
    mean = root * s.values[_LEAK] + difference * s.values[_CLEARANCE]
    # All of it may be that of a valve as leaky as its prior allows; the law of the leak is unknown.
    of_valve = 0.5 * min(abs(mean), 2.0 * difference)
    doubt = of_valve * of_valve + LAW * LAW * mean * mean
    out[MEAN] = mean
    out[MEAN_ERROR] = np.sqrt(abs(combined_variance(root, difference, s.inverse)) + doubt)


@equation
def nan_unless_finite(out: Any) -> None:
    """Set all values of an estimate to NaN unless all are finite."""
    # 0 x is NaN if x is NaN or infinite: the sum spreads it without a branch.
    nothing = 0.0
    for i in range(DISAGREEMENT):
        nothing += 0.0 * out[i]
    for i in range(DISAGREEMENT):
        out[i] += nothing


@equation
def take_window(
    state: RlsState, r: int, columns: Any, targets: Any, counts: float, known: Assumptions, decay: float,
    row: Any,
) -> None:  # fmt: skip
    """Add the equations of a window to the moments of a record."""
    n_chamber, pressures = targets.shape[0], state.pressures[r]
    # The column of the clearance is ∫ φ ΔP, in the mean of both chambers.
    difference = 0.5 * (columns[0, _CLEARANCE] + columns[n_chamber - 1, _CLEARANCE])
    state.counts[r] = decay * state.counts[r] + counts
    is_finite = abs(columns[0, _LEAK]) + abs(difference) < math.inf
    pressures[0] = decay * pressures[0] + (known.half_time if is_finite else 0.0)
    pressures[1] = decay * pressures[1] + (abs(columns[0, _LEAK]) if is_finite else 0.0)
    pressures[2] = decay * pressures[2] + (abs(difference) if is_finite else 0.0)
    for chamber in range(n_chamber):
        for i in range(_WIDTH):
            for j in range(i + 1):
                state.moments[r, chamber, i, j] *= decay
    if counts > 0.0:
        for chamber in range(n_chamber):
            for i in range(N_UNKNOWN):
                row[i] = known.deviations[i] * columns[chamber, i] / known.error
            row[N_UNKNOWN] = targets[chamber] / known.error
            for i in range(_WIDTH):
                for j in range(i + 1):
                    state.moments[r, chamber, i, j] += row[i] * row[j]


@equation
def estimate(state: RlsState, r: int, prior: Any, known: Assumptions, s: Scratch, out: Any) -> None:
    """Write an estimate of a record; NaN if it is not finite."""
    deviations, reference = known.deviations, known.reference
    moments, count = state.moments[r], state.counts[r]
    n_chamber = moments.shape[0]
    out[MISFIT], out[UNDETERMINED] = fit(moments, 0, n_chamber, count, prior, 1.0, known, s)
    write_estimate(reference, deviations, s, out)
    # A laminar leak looks like clearance, so for a flow of any law that may be as large as a leak.
    of_valve, of_leak = deviations[_CLEARANCE], deviations[_LEAK] / np.sqrt(reference)
    wider = max(1.0, of_leak / of_valve) if of_valve > 0.0 else 1.0
    fit(moments, 0, n_chamber, count, prior, wider, known, s)
    write_flow(reference, state.pressures[r], deviations, s, out)
    nan_unless_finite(out)


@equation
def disagreement(state: RlsState, r: int, prior: Any, known: Assumptions, s: Scratch) -> float:
    """Difference between the K_i of each chamber alone, over its standard deviation."""
    moments, count = state.moments[r], state.counts[r]
    difference, variance = 0.0, 0.0
    for chamber in range(moments.shape[0]):
        fit(moments, chamber, chamber + 1, count, prior, 1.0, known, s)
        difference = s.values[_LEAK] - difference
        variance += s.inverse[_LEAK, _LEAK]
    found: float = abs(difference) / np.sqrt(abs(variance))
    return found


@kernel
def follow_windows(
    columns: Array,
    targets: Array,
    counts: Array,
    due: NDArray[np.int64],
    priors: Array,
    known: Assumptions,
    decay: float,
    state: RlsState,
    scratch: Scratch,
    estimates: Array,
) -> None:
    """Process windows of streams, and fill the estimates (n_record, n_instant, N_ESTIMATE).

    `columns` (n_record, n_window, n_chamber, N_UNKNOWN), `targets` [m³] and `counts` (n_record, n_window), 1
    if a window is valid, else 0; forgetting continues in both cases. `due` (n_instant,): number of these
    windows that are complete at each estimate. `priors` (n_record, n_instant, N_UNKNOWN): prior means over
    the prior deviations. `decay`: forgetting factor per window.

    The state is updated in place. Estimates are NaN once a window was not finite; they are not fed back, so
    they cannot diverge.
    """
    for r in range(estimates.shape[0]):
        n_taken = 0
        for instant in range(due.shape[0] + 1):
            n_due = due[instant] if instant < due.shape[0] else columns.shape[1]
            while n_taken < n_due:
                of_window = columns[r, n_taken], targets[r, n_taken], counts[r, n_taken]
                take_window(state, r, *of_window, known, decay, scratch.row)
                n_taken += 1
            if instant < due.shape[0]:
                out, prior = estimates[r, instant], priors[r, instant]
                estimate(state, r, prior, known, scratch, out)
                if instant == due.shape[0] - 1 and columns.shape[2] == 2:
                    out[DISAGREEMENT] = disagreement(state, r, prior, known, scratch)
