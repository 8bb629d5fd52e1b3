"""What all windows of a record tell together: its mean leakage flow, and constants that are likeliest wrong.

The K_i of a whole record may differ over the stroke, as that of a scored bore does. A leak in a part of the
stroke, taken for one everywhere, looks like a gain of the valve and like compression. Noise is not alike in
windows that do not overlap, but an error of the model is, even one below the stated error: the stated
deviation counts the covariance of such residuals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.balancing import VolumeBalance, WindowOptions, counting_windows
from hydrofdi.indicators.estimation.chamber_balance import COMPRESSIBILITY, N_UNKNOWN, UNKNOWNS, weak_weights
from hydrofdi.indicators.estimation.weak_rls import CORRELATED, LAW, N_FIT, WIDER, Assumptions
from hydrofdi.indicators.nominal_actuator import plant_constants
from hydrofdi.records import Array, RecordBatch
from hydrofdi.settings.messages import shown_quantity

_LEAK, _CLEARANCE = UNKNOWNS.index("internal_coefficient"), UNKNOWNS.index("clearance")

_N_PLACE = 10
"""Number of parts of the way of the piston, each with a K_i of its own, the last the common one."""

_N_OWN = _N_PLACE - 1

_DIFFER = 3.0
"""Prior deviation of the K_i of a place over the common one, as of a score of a third of the way."""

_APART, _LEAST_PAIRS = (2, 3, 4), 8
"""Distances of windows that do not overlap, and number of pairs from which on a covariance counts."""

_ENDS = (0.01, 0.99)
"""Quantiles of the position between which the parts lie."""


def mean_flows(balance: VolumeBalance, counts: Array, priors: Array) -> Array:
    """Mean flow across piston and closed valve of any law, and its standard deviation [m³/s].

    Shape (2, n_record), from the windows that count (n_record, n_window); `priors` (n_record, N_UNKNOWN):
    prior means over the prior deviations. NaN if a value is not finite.
    """
    options, records, (columns, targets) = balance.options, balance.records, balance.equations
    known, (first, second) = options.assumptions(records), balance.pressures
    position, difference = np.ascontiguousarray(balance.position), np.ascontiguousarray(first - second)
    scales = np.concatenate((known.deviations, np.full(_N_OWN, known.deviations[_LEAK])))
    roots = np.sign(difference) * np.sqrt(np.abs(difference))
    flows = np.full((2, len(columns)), math.nan)
    for r, root in enumerate(roots):
        ends = np.quantile(position[r], _ENDS)
        place = np.clip(_N_PLACE * (position[r] - ends[0]) / max(np.ptp(ends), 1e-12), 0, _N_PLACE - 1)
        is_at = np.floor(place) == np.arange(_N_OWN)[:, None]
        by_place = _integrals(is_at * root, options.half_window, records.sampling_frequency)
        regressors = np.concatenate(
            (columns[r], np.broadcast_to(by_place.T[:, None], (*columns.shape[1:3], _N_OWN))), axis=2
        )
        used = counts[r] > 0.0
        rows = (regressors[used] * scales / known.error).reshape(-1, scales.size)
        weights = scales * np.concatenate((np.zeros(N_UNKNOWN), np.mean(is_at * np.abs(root), axis=1)))
        weights[_LEAK] = scales[_LEAK] * np.mean(np.abs(root))
        weights[_CLEARANCE] = scales[_CLEARANCE] * np.mean(np.abs(difference[r]))
        if np.isfinite(rows).all() and np.isfinite(weights).all():
            of_window = targets[r][used].ravel() / known.error
            alike, *_ = map_estimate(rows[:, :N_UNKNOWN], of_window, priors[r], known)
            # a short record does not tell the places apart: they differ by few times the common K_i
            own = min(1.0, _DIFFER * abs(float(alike[_LEAK])))
            rows[:, N_UNKNOWN:] *= own
            weights[N_UNKNOWN:] *= own
            flows[:, r] = _flow(rows, of_window, used, weights, priors[r], known)
    return flows


def _integrals(signals: Array, half: int, sampling_frequency: float) -> Array:
    """∫ φ s over all windows, shape (n_signal, n_window)."""
    first, second = weak_weights(half, sampling_frequency)[:, 0]
    blocks = signals[:, : signals.shape[1] // half * half].reshape(len(signals), -1, half)
    return np.asarray(np.sum(blocks[:, :-1] * first + blocks[:, 1:] * second, axis=2))


def _inverse(matrix: Array) -> Array:
    """Inverse of a positive definite matrix."""
    # Unknowns whose priors say nothing have other scales by far: a diagonal of ones keeps the digits.
    scale = 1.0 / np.sqrt(np.diag(matrix))
    return np.asarray(np.linalg.inv(matrix * scale * scale[:, None]) * scale * scale[:, None])


def _covariance(residuals: Array, used: NDArray[np.bool_]) -> float:
    """Largest covariance of residuals (n_used, n_chamber) in windows that do not overlap."""
    of_window, largest = np.zeros((used.size, residuals.shape[1])), 0.0
    of_window[used] = residuals
    for apart in _APART:
        n_pair = np.count_nonzero(used[apart:] & used[:-apart])
        if n_pair >= _LEAST_PAIRS:
            total = abs(float(np.sum(of_window[apart:] * of_window[:-apart])))
            largest = max(largest, total / (n_pair * residuals.shape[1]))
    return largest


def map_estimate(
    rows: Array, targets: Array, prior: Array, known: Assumptions
) -> tuple[Array, Array, Array, Array]:
    """Estimate over the prior deviations as `weak_rls` makes it, residuals, normal matrix and precisions."""
    deviations, n_unknown = known.deviations, rows.shape[1]
    normal, right, precision = rows.T @ rows, rows.T @ targets, np.ones(n_unknown)
    mean, at_zero = np.pad(prior, (0, n_unknown - N_UNKNOWN)), -math.inf
    if deviations[_CLEARANCE] > 0.0:
        # a laminar leak looks like clearance, so that of a flow of any law may be as large as a leak
        of_leak = deviations[_LEAK] / math.sqrt(known.reference)
        precision[_CLEARANCE] = min(1.0, deviations[_CLEARANCE] / of_leak) ** 2
    if deviations[COMPRESSIBILITY] > 0.0:
        at_zero = -1.0 / (known.modulus * deviations[COMPRESSIBILITY])
    variance, estimate, residuals = 1.0, mean, targets
    for _ in range(N_FIT):
        covariance = _inverse(normal / variance + np.diag(precision))
        estimate = covariance @ (right / variance + mean)
        for index, least in ((COMPRESSIBILITY, at_zero), (_CLEARANCE, 0.0)):
            estimate -= min(estimate[index] - least, 0.0) / covariance[index, index] * covariance[index]
        residuals = targets - rows @ estimate
        square = float(np.sum(residuals**2)) / max(targets.size, 1)
        if not square > variance:
            break
        variance = square
    return estimate, residuals, normal, precision


def _flow(
    rows: Array, targets: Array, used: NDArray[np.bool_], weights: Array, prior: Array, known: Assumptions
) -> tuple[float, float]:
    """Sum of the unknowns times their weights, and its standard deviation."""
    estimate, residuals, normal, precision = map_estimate(rows, targets, prior, known)
    n_used = np.count_nonzero(used)
    excess = float(np.sum(residuals**2)) / max(targets.size, 1) - 1.0
    of_model = max(excess, _covariance(residuals.reshape(n_used, -1), used) if n_used else 0.0)
    covariance = _inverse(normal / (1.0 + CORRELATED * of_model) + np.diag(precision))
    along, flow = covariance @ weights, float(weights @ estimate)
    wider = np.where(np.arange(weights.size) < N_UNKNOWN, WIDER**2 - 1.0, 0.0)
    wider[[_LEAK, _CLEARANCE]] = 0.0
    of_valve = 0.5 * min(abs(flow), 2.0 * weights[_CLEARANCE])
    variance = weights @ along + np.sum(wider * along**2) + of_valve**2 + (LAW * flow) ** 2
    return flow, math.sqrt(variance)


_MOST_RECORDS, _LONGEST = 2, 20.0
"""Records of a batch, and their first part [s], that are looked at."""

_OCTAVES = np.linspace(-2.5, 2.5, 11)
"""Changes that are tried first, as powers of two."""

_MOST, _LIKE, _LEAST, _SURE = 0.75, 0.1, 0.05, 30.0
"""Share of the misfit that a constant must explain; how much less a second one may; least change; least
decrease of twice the negative logarithm of the likelihood."""

_IMPOSSIBLE = 1e9
"""Of a data sheet with which a chamber has no volume."""

_SAME_AS = {"flow_gain": ("area_gradient", "spool_gain")}
"""Constant → others that the balance sees only in their product."""


class Wrong(NamedTuple):
    """A constant that may be wrong, the value that would fit, and its share of the misfit."""

    name: str
    value: float
    share: float


def likeliest_wrong(options: WindowOptions, records: RecordBatch) -> list[Wrong]:
    """At most two constants, each of which alone would explain most of the misfit of healthy records."""
    from scipy.optimize import minimize_scalar

    records = records.rows(range(min(_MOST_RECORDS, records.n_record)))
    records = records.window(0, min(records.n_time, round(_LONGEST * records.sampling_frequency)))
    skipped = {name for others in _SAME_AS.values() for name in others} | {"damping_ratio", "position_zero"}
    known = [name for name in plant_constants(options) if name not in skipped]
    now = {name: value for name in known if (value := getattr(options, name))}

    def doubt(name: str, octaves: float) -> float:
        changed = options.model_copy(update={name: now[name] * 2.0**octaves})
        return _doubt(changed, records)

    whole, likeliest = _doubt(options, records), list[Wrong]()
    for name in now if whole > _SURE else ():
        tried = [doubt(name, octaves) for octaves in _OCTAVES]
        best = float(_OCTAVES[int(np.argmin(tried))])
        step = float(_OCTAVES[1] - _OCTAVES[0])
        bounds = best - step, best + step
        fitted = minimize_scalar(lambda x, name=name: doubt(name, x), bounds=bounds, method="bounded",
                                 options={"xatol": 0.01, "maxiter": 10})  # fmt: skip
        if abs(fitted.x) > np.log2(1.0 + _LEAST):
            likeliest.append(Wrong(name, now[name] * 2.0 ** float(fitted.x), float(1.0 - fitted.fun / whole)))
    likeliest = [each for each in likeliest if each.share > max(_MOST, _SURE / whole)]
    likeliest.sort(key=lambda each: -each.share)
    return [each for each in likeliest[:2] if each.share > likeliest[0].share - _LIKE]


def sentence(options: WindowOptions, wrong: Sequence[Wrong]) -> str:
    """What is likeliest wrong, or that no single constant is."""
    units, said = plant_constants(options), list[str]()
    for name, value, share in wrong:
        now, fits = (shown_quantity(each, units[name]) for each in (getattr(options, name), value))
        whole = " · ".join((name, *_SAME_AS.get(name, ())))
        said.append(f"{whole} ({name} = {fits} instead of {now} would explain {share:.0%})")
    return f"likeliest wrong: {' or '.join(said)}" if said else "no single constant explains most of it"


def _doubt(options: WindowOptions, records: RecordBatch) -> float:
    """Twice the negative logarithm of the likelihood: of the residuals beyond the stated error, and of the
    unknowns beside their priors; zero if the data sheet is right.
    """
    balance = VolumeBalance(records, options)
    columns, targets = balance.equations
    counts = counting_windows(balance.spool, records.sampling_frequency, options)
    known, total = options.assumptions(records), 0.0
    free = [UNKNOWNS.index(name) for name in ("internal_coefficient", "clearance")]
    for r in range(records.n_record):
        used = counts[r] > 0.0
        rows = (columns[r][used] * known.deviations / known.error).reshape(-1, N_UNKNOWN)
        if not (len(rows) and np.isfinite(rows).all()):
            return _IMPOSSIBLE
        estimate, residuals, *_ = map_estimate(
            rows, targets[r][used].ravel() / known.error, np.zeros(N_UNKNOWN), known
        )
        estimate[free] = 0.0
        square = max(1.0, float(np.mean(residuals**2)))
        total += len(rows) / CORRELATED * np.log(square) + float(np.sum(estimate**2))
    return total
