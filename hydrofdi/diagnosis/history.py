"""What records of a healthy machine look like: centre and scatter of what faults may change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hydrofdi.diagnosis.balance import FaultBalance, Fitted
from hydrofdi.diagnosis.causes import CAUSES, LEAKS, N_PLACE, NAMES, PLACE
from hydrofdi.diagnosis.signatures import signature_names, signatures
from hydrofdi.errors import DataError
from hydrofdi.indicators.catalogue.balances import BalanceOptions
from hydrofdi.records import Array, RecordBatch

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
class History:
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

    def without(self, row: int) -> History:
        """That of the other records."""
        return _learned(self.balance, self.variance, *(np.delete(each, row, axis=0) for each in self.seen))

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


def history_of(healthy: Sequence[RecordBatch], options: BalanceOptions) -> History:
    """History of a machine from its healthy records, at least `FEWEST`."""
    balance = balance_of(healthy, options)
    fits = [balance.fit(batch) for batch in healthy]
    variance = _scattering(balance, fits)
    parts = [signatures(balance, batch, variance, own) for batch, own in zip(healthy, fits, strict=True)]
    found = np.concatenate([part[0] for part in parts])
    gains = np.concatenate([part[1].gains for part in parts])
    noises = np.concatenate([part[1].noise for part in parts])
    return _learned(balance, variance, found, gains, noises)


def _learned(balance: FaultBalance, variance: float, found: Array, gains: Array, noises: Array) -> History:
    """History from the signatures of healthy records (n_record, n_name), their gains and covariances."""
    names = signature_names(balance.options)
    n_record, n_own = len(found), len(NAMES)
    deviations = found - found.mean(axis=0)
    squares = np.sum(deviations**2, axis=0) / (n_record - 1)
    noise = np.mean(noises, axis=0)
    expected = np.diag(squares)
    gain, changes = gains.mean(axis=0), np.diag(_daily(balance, found.mean(axis=0)) ** 2)
    expected[:n_own, :n_own] = noise + gain @ changes @ gain.T
    expected[-1, -1] = max(squares[-1], 0.1**2)
    expected[n_own:-1, n_own:-1] += np.diag(_usual(balance, found.mean(axis=0)[n_own:-1]) ** 2)
    own = _PRIOR_RECORDS + n_record - 1
    # 1 + 1/n for a further record, as the centre itself scatters.
    scatter = (_PRIOR_RECORDS * expected + deviations.T @ deviations) / own * (1.0 + 1.0 / n_record)
    spread = _regular(scatter)
    return History(balance, names, found.mean(axis=0), spread, own, variance, noise, (found, gains, noises))


def _scattering(balance: FaultBalance, fits: Sequence[Fitted]) -> float:
    """Squared error of the equations over the stated one that agrees with the scatter of the estimates: most
    errors of the model repeat from record to record, so that they scatter less than they misfit."""
    variance = balance.variance(fits)
    # Estimates and their errors depend on each other: fixed-point steps.
    for _ in range(6):
        found = [balance.estimate(each, variance) for each in fits]
        values = np.concatenate([each.values for each in found])
        noise = np.diag(np.mean(np.concatenate([each.noise for each in found]), axis=0))
        told = noise > 1e-9
        # The median over the unknowns of which the records tell anything.
        share = float(np.median(np.var(values[:, told], axis=0, ddof=1) / noise[told]))
        # The median of χ²/dof (Wilson and Hilferty) is what is expected of it.
        variance = max(1.0, variance * share / (1.0 - 2.0 / (9.0 * (len(values) - 1))) ** 3)
    return variance


def history_of_sheet(records: RecordBatch, options: BalanceOptions) -> History:
    """What the data sheet alone says of a machine, and of records like these."""
    balance = balance_of([records], options)
    fitted = balance.fit(records)
    variance = balance.variance([fitted])
    found, estimates = signatures(balance, records, variance, fitted)
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
    for place in range(n_own, len(names)):
        centre[place] = float(np.mean(found[:, place]))
        scatter[place, place] = (_ANY * max(abs(centre[place]), 1e-9)) ** 2
    # ln misfit, as the variance is about 25 (`balance._CORRELATED`) times its square.
    centre[-1], scatter[-1, -1] = 0.5 * np.log(max(1.0, variance / 25.0)), 0.5**2
    return History(balance, names, centre, _regular(scatter), _PRIOR_RECORDS, variance)


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
    found = np.array([changes.get(name, 0.0) for name in CAUSES]) / balance.scales
    for name in ("clearance", "laminar"):
        found[PLACE[name]] = 0.25 * abs(centre[PLACE[name]])
    return found


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))


def _regular(scatter: Array) -> Array:
    """A scatter that can be inverted: a ten-thousandth of each variance, and of the unknowns' scales."""
    floor = np.diag(scatter) * 1e-4
    floor[: len(NAMES)] += _LEAST**2
    return _symmetric(scatter) + np.diag(floor + 1e-30)
