"""What records of a healthy machine look like: centre and scatter of what faults may change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.diagnosis.balance import (
    CAUSES,
    LEAKS,
    N_PLACE,
    NAMES,
    PLACE,
    FaultBalance,
    FlowEquations,
    FlowEstimates,
)
from hydrofdi.errors import DataError
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
    balance: FaultBalance, records: RecordBatch, variance: float, fitted: FlowEquations | None = None
) -> tuple[Array, FlowEstimates]:
    """What is compared of each record (n_record, n_name), and the estimates."""
    estimates = balance.estimate(fitted or balance.fit(records), variance)
    columns = [estimates.values]
    pressures = [records[P1]]
    if balance.both:
        columns.append(forces(balance, records))
        pressures.append(records[P2])
    mean = np.mean(pressures, axis=(0, 2))
    # The floor keeps a perfect fit from being far away in the logarithm.
    columns.append(np.stack((mean, np.log(np.maximum(estimates.misfits, 0.03))), axis=1))
    return np.concatenate(columns, axis=1), estimates


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
    compared = np.zeros((records.n_record, len(FORCES)))
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
        compared[row] = values[0], values[1], remains, values[2]
    return compared


FEWEST = 3
"""Fewest healthy records that state a history; with fewer, the data sheet does."""

_PRIOR_RECORDS = 20
"""Number of records that the expected scatter counts for."""

_USUAL = 2.5e-3
"""Usual change of friction, force and pressure from record to record, over supply pressure times area."""

_LEAST = 0.005
"""Least scatter of an unknown, over its scale."""

_ANY = 1e3
"""Deviation of what a data sheet does not state, over that of the record."""


@dataclass(frozen=True)
class HealthyMachine:
    """A healthy machine: centre (n_name,) and scatter (n_name, n_name) of a further record's signature.

    `dof`: degrees of freedom of the scatter; `variance`: of the errors of equations. Of the healthy records
    that it rests on, none if on the data sheet: `noise` (N, N), the mean covariance that is expected of their
    estimates; and `seen`, their signatures, gain matrices and expected covariances.
    """

    balance: FaultBalance
    names: tuple[str, ...]
    centre: Array
    scatter: Array
    dof: float
    variance: float
    noise: Array | None = None
    seen: tuple[Array, ...] = ()

    @property
    def n_record(self) -> int:
        """Healthy records that it rests on; 0 if on the data sheet."""
        return len(self.seen[0]) if self.seen else 0

    def without(self, row: int) -> HealthyMachine:
        """That of the other records."""
        return _learned(self.balance, self.variance, *(np.delete(array, row, axis=0) for array in self.seen))

    @property
    def causes(self) -> tuple[str, ...]:
        """What faults may change: the causes of the balance, and what is compared beside its unknowns."""
        return (*CAUSES, *self.names[len(NAMES) :])

    def scatter_of(self, noise: Array) -> Array:
        """Scatter of a record with this covariance of estimates: larger where it tells less than before."""
        scatter, n_own = self.scatter.copy(), len(NAMES)
        if self.noise is not None:
            own = noise + _LEAST**2 * np.eye(n_own)
            factor = np.linalg.cholesky(self.noise + _LEAST**2 * np.eye(n_own))
            half = np.linalg.solve(factor, np.linalg.solve(factor, own).T)
            # Eigenvalues above one: directions in which it scatters more.
            ratios, directions = np.linalg.eigh(_symmetric(half))
            more = (factor @ directions) * np.sqrt(np.maximum(ratios - 1.0, 0.0))
            scatter[:n_own, :n_own] += more @ more.T
        return scatter

    def value(self, name: str) -> float:
        """Centre of a quantity that has no scale of its own."""
        return float(self.centre[self.names.index(name)])


def balance_of(batches: Sequence[RecordBatch], options: BalanceOptions) -> FaultBalance:
    """The balance, with the largest opening and the places of K_i in some records."""
    shares, positions, opening = np.linspace(0.02, 0.98, N_PLACE), list[Array](), 0.0
    for batch in batches:
        opening = max(opening, float(np.quantile(np.abs(options.spool_position(batch)), 0.99)))
        positions.append(options.position(batch).ravel())
    at = np.quantile(np.concatenate(positions), shares)
    if not (opening > 0.0 and at[-1] > at[0]):
        raise DataError("the valve or the piston does not move: nothing can be told of the machine")
    # Half way to even steps: each place has samples, and none coincide where the piston rests.
    return FaultBalance(options, opening, tuple((0.5 * (at + np.linspace(at[0], at[-1], N_PLACE))).tolist()))


def history_of(healthy: Sequence[RecordBatch], options: BalanceOptions) -> HealthyMachine:
    """History of a machine from its healthy records, at least `FEWEST`."""
    balance = balance_of(healthy, options)
    fits = [balance.fit(batch) for batch in healthy]
    variance = _scattering(balance, fits)
    parts = [signatures(balance, batch, variance, own) for batch, own in zip(healthy, fits, strict=True)]
    seen = np.concatenate([part[0] for part in parts])
    gains = np.concatenate([part[1].gains for part in parts])
    noises = np.concatenate([part[1].noise for part in parts])
    return _learned(balance, variance, seen, gains, noises)


def _learned(
    balance: FaultBalance, variance: float, seen: Array, gains: Array, noises: Array
) -> HealthyMachine:
    """History from the signatures of healthy records (n_record, n_name), their gains and covariances."""
    names = signature_names(balance.options)
    n_record, n_own = len(seen), len(NAMES)
    deviations = seen - seen.mean(axis=0)
    squares = np.sum(deviations**2, axis=0) / (n_record - 1)
    noise = np.mean(noises, axis=0)
    expected = np.diag(squares)
    gain, changes = gains.mean(axis=0), np.diag(_daily(balance, seen.mean(axis=0)) ** 2)
    expected[:n_own, :n_own] = noise + gain @ changes @ gain.T
    expected[-1, -1] = max(squares[-1], 0.1**2)
    expected[n_own:-1, n_own:-1] += np.diag(_usual(balance, seen.mean(axis=0)[n_own:-1]) ** 2)
    own = _PRIOR_RECORDS + n_record - 1
    # 1 + 1/n for a further record, as the centre itself scatters.
    scatter = (_PRIOR_RECORDS * expected + deviations.T @ deviations) / own * (1.0 + 1.0 / n_record)
    spread = _regular(scatter)
    return HealthyMachine(
        balance, names, seen.mean(axis=0), spread, own, variance, noise, (seen, gains, noises)
    )


def _scattering(balance: FaultBalance, fits: Sequence[FlowEquations]) -> float:
    """Squared error of the equations over the stated one that agrees with the scatter of the estimates: most
    errors of the model repeat from record to record, so that they scatter less than they misfit."""
    variance = balance.variance(fits)
    # Estimates and their errors depend on each other: fixed-point steps.
    for _ in range(6):
        estimates = [balance.estimate(fitted, variance) for fitted in fits]
        values = np.concatenate([estimate.values for estimate in estimates])
        noise = np.diag(np.mean(np.concatenate([estimate.noise for estimate in estimates]), axis=0))
        told = noise > 1e-9
        # The median over the unknowns of which the records tell anything.
        share = float(np.median(np.var(values[:, told], axis=0, ddof=1) / noise[told]))
        # The median of χ²/dof (Wilson and Hilferty) is what is expected of it.
        variance = max(1.0, variance * share / (1.0 - 2.0 / (9.0 * (len(values) - 1))) ** 3)
    return variance


def history_of_sheet(records: RecordBatch, options: BalanceOptions) -> HealthyMachine:
    """What the data sheet alone says of a machine, and of records like these."""
    balance = balance_of([records], options)
    fitted = balance.fit(records)
    variance = balance.variance([fitted])
    seen, estimates = signatures(balance, records, variance, fitted)
    names, n_own = signature_names(options), len(NAMES)
    stated = options.prior_deviations(records, options.n_pressure)
    leaks = 0.002 * balance.flow / np.sqrt(options.reference_pressure)
    deviations = np.array([0.0 if name in LEAKS else stated.get(name, 0.0) for name in CAUSES])
    deviations[: len(LEAKS)] = leaks
    for name in ("gain_1", "gain_2", "position_gain"):
        deviations[PLACE[name]] = 0.005
    gain = estimates.gains.mean(axis=0)
    scatter = np.zeros((len(names), len(names)))
    scatter[:n_own, :n_own] = np.mean(estimates.noise, axis=0)
    scatter[:n_own, :n_own] += gain @ np.diag((deviations / balance.scales) ** 2) @ gain.T
    centre = np.zeros(len(names))
    for index in range(n_own, len(names)):
        centre[index] = float(np.mean(seen[:, index]))
        scatter[index, index] = (_ANY * max(abs(centre[index]), 1e-9)) ** 2
    # ln misfit, as the variance is about 25 (`balance._CORRELATED`) times its square.
    centre[-1], scatter[-1, -1] = 0.5 * np.log(max(1.0, variance / 25.0)), 0.5**2
    return HealthyMachine(balance, names, centre, _regular(scatter), _PRIOR_RECORDS, variance)


def _usual(balance: FaultBalance, centre: Array) -> Array:
    """Usual changes of forces and mean pressure of a healthy machine from record to record."""
    options = balance.options
    pressure = _USUAL * options.supply_pressure
    if not balance.both:
        return np.array([pressure])
    force = pressure * min(options.areas)
    return np.array([force, 0.05 * abs(centre[1]), force, 0.01 * abs(centre[3]), pressure])


def _daily(balance: FaultBalance, centre: Array) -> Array:
    """Usual changes of a healthy machine from record to record, over the scales (N,): oil 6 K warmer or
    colder, which changes its viscosity by a quarter, supply, drift of sensors and of the null."""
    options, opening = balance.options, balance.largest_opening
    changes = {
        "compressibility": 0.04 / options.bulk_modulus,
        "free_air": 0.002,
        "offset": 2e-3 * opening,
        "lap": 1e-3 * opening,
        "supply": 0.005,
        "return_pressure": 1e-3 * options.supply_pressure,
        "flow_gain": 0.005,
        "bias_1": 3e-4 * options.supply_pressure,
        "bias_2": 3e-4 * options.supply_pressure,
    }
    daily = np.array([changes.get(name, 0.0) for name in CAUSES]) / balance.scales
    for name in ("clearance", "laminar"):
        daily[PLACE[name]] = 0.25 * abs(centre[PLACE[name]])
    return daily


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))


def _regular(scatter: Array) -> Array:
    """A scatter that can be inverted: a ten-thousandth of each variance, and of the unknowns' scales."""
    floor = np.diag(scatter) * 1e-4
    floor[: len(NAMES)] += _LEAST**2
    return _symmetric(scatter) + np.diag(floor + 1e-30)
