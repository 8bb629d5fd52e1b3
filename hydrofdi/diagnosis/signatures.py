"""What is compared of each record: estimates of the balance, forces, mean pressure and misfit."""

from __future__ import annotations

import numpy as np

from hydrofdi.diagnosis.balance import Estimates, FaultBalance, Fitted
from hydrofdi.diagnosis.causes import NAMES
from hydrofdi.indicators.balancing import P1, P2
from hydrofdi.indicators.catalogue.balances import BalanceOptions
from hydrofdi.records import Array, RecordBatch

FORCES = ("coulomb", "viscous", "force", "stiffness")
"""Friction at all speeds [N] and per speed [N·s/m], force that remains [N], and force per position [N/m]."""

OTHERS = ("pressure", "log_misfit")
"""Mean of the measured chamber pressures [Pa], and logarithm of the misfit."""

_SMOOTHING, _DIFFERENCE, _SLOW = 0.018, 0.1, 0.05
"""Time over which speeds are smoothed and between which forces are compared [s]; speed below which dry
friction is linear, over the largest speed."""


def signature_names(options: BalanceOptions) -> tuple[str, ...]:
    """What is compared, in order: unknowns of the balance, forces if both pressures are measured, others."""
    return (*NAMES, *(FORCES if options.chambers == "both" else ()), *OTHERS)


def signatures(
    balance: FaultBalance, records: RecordBatch, variance: float, fitted: Fitted | None = None
) -> tuple[Array, Estimates]:
    """What is compared of each record (n_record, n_name), and the estimates."""
    found = balance.estimate(fitted or balance.fit(records), variance)
    columns = [found.values]
    pressures = [records[P1]]
    if balance.both:
        columns.append(forces(balance, records))
        pressures.append(records[P2])
    mean = np.mean(pressures, axis=(0, 2))
    # The floor keeps a perfect fit from being far away in the logarithm.
    columns.append(np.stack((mean, np.log(np.maximum(found.misfits, 0.03))), axis=1))
    return np.concatenate(columns, axis=1), found


def forces(balance: FaultBalance, records: RecordBatch) -> Array:
    """`FORCES` of each record (n_record, 4), robust against jumps of the load."""
    from scipy.ndimage import uniform_filter1d

    options, frequency = balance.options, records.sampling_frequency
    position = options.position(records)
    n_smooth = max(3, round(_SMOOTHING * frequency))
    speed = uniform_filter1d(np.gradient(position, axis=1) * frequency, n_smooth, axis=1)
    acceleration = np.gradient(speed, axis=1) * frequency
    # A high quantile, as noise sets the maximum.
    slow = _SLOW * max(float(np.quantile(np.abs(speed), 0.99)), 1e-9)
    pushed = options.areas[0] * records[P1] - options.areas[1] * records[P2]
    # Smoothed like the speed, so that an oscillation looks the same in both.
    pushed = uniform_filter1d(pushed, n_smooth, axis=1)
    # Without the ends, at which the filter reflects the speed.
    columns = np.stack((np.tanh(speed / slow), speed, position, acceleration), axis=2)[:, n_smooth:-n_smooth]
    pushed = pushed[:, n_smooth:-n_smooth]
    behind = max(1, round(_DIFFERENCE * frequency))
    found = np.zeros((records.n_record, len(FORCES)))
    for row in range(records.n_record):
        # Differences leave out a load that lasts longer; weights those during which it jumps.
        own, force = columns[row, behind:] - columns[row, :-behind], pushed[row]
        change = force[behind:] - force[:-behind]
        weights = np.ones(len(change))
        for _ in range(6):
            values = np.linalg.lstsq(own * weights[:, None], change * weights, rcond=None)[0]
            left = np.abs(change - own @ values)
            # Equations beyond twice the robust deviation lose weight; 1e-30 is for a perfect fit.
            weights = 1.0 / (1.0 + (left / (2.0 * 1.4826 * np.median(left) + 1e-30)) ** 2)
        remains = np.mean(force - columns[row] @ values)
        # The last value, the moving mass, is fitted but not compared.
        found[row] = values[0], values[1], remains, values[2]
    return found
