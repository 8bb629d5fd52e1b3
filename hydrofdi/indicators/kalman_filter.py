"""Base of the Kalman filter indicators: one filter per record of a stream, and its information."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.ekf_stream import N_SUM, Streams, Tuning, follow, workspace
from hydrofdi.estimation.observability import finite_horizon_gramian
from hydrofdi.estimation.plant import N_MOVING, N_STATE, STATES
from hydrofdi.estimation.prediction import TANGENT_SHAPE, predict
from hydrofdi.indicators.information import Information, Unknown
from hydrofdi.indicators.kalman import LITRE_PER_MINUTE, MEASURED, MOTION, KalmanOptions
from hydrofdi.indicators.recursive import RecursiveIndicator, State, Trace, instants
from hydrofdi.records import Array, Channel, RecordBatch

_NAMES_AND_UNITS = {
    "pressure_1": ("P1", "Pa", 1e6),
    "pressure_2": ("P2", "Pa", 1e6),
    "position": ("position", "m", 1e-3),
    "velocity": ("velocity", "m/s", 1e-3),
    "resistance": ("friction and load", "N", 1.0),
    "leakage": ("leakage", "m^3/s", LITRE_PER_MINUTE),
    "bulk_modulus": ("bulk modulus", "1", 1.0),
    "supply": ("supply pressure", "1", 1.0),
    "flow_gain": ("flow gain", "1", 1.0),
    "offset": ("valve null", "m", 1e-6),
    "lap": ("lap", "m", 1e-6),
    "clearance": ("clearance", "m^3/(s*Pa)", 1e-15),
    "bias_1": ("bias of P1", "Pa", 1e6),
    "bias_2": ("bias of P2", "Pa", 1e6),
}
"""State → name and unit in tables, and the factor from estimator units to that unit."""


def plant_information(options: KalmanOptions, records: RecordBatch, covariance: Array) -> Information:
    """Information of the first record about the estimated states.

    The Gramian refers to the initial states and assumes an exact plant model.

    Parameters
    ----------
    options : KalmanOptions
    records : RecordBatch
    covariance : ndarray, shape (N_STATE, N_STATE)
        Covariance of a filter after the record, in estimator units.
    """
    prior = np.sqrt(options.prior_variances(records))
    (open_,) = np.nonzero(prior)
    scale, chosen = np.outer(prior[open_], prior[open_]), np.ix_(open_, open_)
    seen = np.eye(len(options.sensor_variances), N_STATE)
    gramian = finite_horizon_gramian(_transitions(options, records), seen, np.sqrt(options.sensor_variances))
    words = [(*_NAMES_AND_UNITS[name], prior[place]) for place, name in enumerate(STATES) if prior[place]]
    return Information(
        tuple(Unknown(name, unit, deviation * size) for name, unit, size, deviation in words),
        gramian[chosen] * scale,
        covariance[chosen] / scale,
        sum(name in MOTION for name, deviation in zip(STATES, prior, strict=True) if deviation),
    )


def _transitions(options: KalmanOptions, records: RecordBatch) -> Array:
    """State transition matrices of the nominal plant, shape (n_time - 1, N_STATE, N_STATE).

    Linearised about the measured pressures and position; the spool position is interpolated linearly.
    """
    frequency, first = records.sampling_frequency, records.rows([0])
    measured = options.measured_states(first)[0]
    spool, n_step = _spool(options, first), len(measured) - 1
    states = np.zeros((n_step, N_STATE))
    states[:, : measured.shape[1]] = measured[:-1]
    states[:, N_MOVING - 1] = np.diff(measured[:, -1]) * frequency
    part = np.linspace(0.0, 1.0, 2 * options.substeps + 1)
    moving = np.empty((n_step, N_MOVING, N_STATE))
    predict(
        states, spool[:-1, None] + np.diff(spool)[:, None] * part, 1.0 / (frequency * options.substeps),
        np.ascontiguousarray(options.supply_of(first)[0]), options.plant,
        np.empty_like(states), moving, np.empty(TANGENT_SHAPE),
    )  # fmt: skip
    transitions = np.tile(np.eye(N_STATE), (n_step, 1, 1))
    transitions[:, :N_MOVING] = moving
    return transitions


def _spool(options: KalmanOptions, records: RecordBatch) -> Array:
    """x_v [mm], shape (n_time,)."""
    drive = options.spool_drive(records)
    if options.spool == "measured":
        return np.asarray(drive[0])
    command = drive / options.spool_gain
    spool, _ = options.follow_command(command, command[:, :1], None, records.sampling_frequency)
    return np.asarray(spool[0])


Chosen = TypeVar("Chosen", bound=KalmanOptions)


@dataclass(frozen=True)
class Estimates:
    """Estimates of a filter at some instants, in estimator units.

    Attributes
    ----------
    means, variances : ndarray, shape (n_record, n_instant, N_STATE)
    sums : ndarray, shape (n_record, n_instant, N_SUM)
        Sums over the samples since the previous instant.
    supply : ndarray, shape (n_record, n_instant)
        Nominal or measured supply pressure [MPa].
    n_sample : int
        Samples between instants.
    """

    means: Array
    variances: Array
    sums: Array
    supply: Array
    n_sample: int


class KalmanFilter(RecursiveIndicator[Chosen]):
    """Base of indicators from the estimates, variances and innovations of a Kalman filter."""

    absence = "the filter diverged, or a sample is not a number"
    is_cheap = False

    @property
    def channels(self) -> frozenset[Channel]:
        """Pressures, position, and what moves the valve."""
        return frozenset(MEASURED) | self.options.valve_channels

    def start(self, records: RecordBatch) -> State:
        """State of the filters before the first sample."""
        n = records.n_record
        return {
            "n_seen": np.zeros(1, dtype=np.int64),
            "start_time": np.array([records.start_time]),
            "mean": np.zeros((n, N_STATE)),
            "covariance": np.zeros((n, N_STATE, N_STATE)),
            "signature": np.zeros((n, N_STATE)),
            "sums": np.zeros((n, N_SUM)),
            "spool": np.zeros((n, 2)),
            "held": np.zeros((n, 2)),
        }

    def step(self, state: State, chunk: RecordBatch) -> tuple[State, Trace]:
        """Process a chunk."""
        moved: dict[str, NDArray[Any]] = {name: array.copy() for name, array in state.items()}
        n_before, frequency = int(moved["n_seen"][0]), chunk.sampling_frequency
        every = self.samples_per_estimate(frequency)
        due = instants(n_before, chunk.n_time, every)
        means, variances = (np.zeros((chunk.n_record, due.size, N_STATE)) for _ in range(2))
        sums = np.zeros((chunk.n_record, due.size, N_SUM))
        supply = self.options.supply_of(chunk)
        samples = self.options.measured_states(chunk), self.options.spool_drive(chunk), supply
        self.follow(moved, n_before, samples, self._tuning(chunk), every, (means, variances, sums))
        moved["n_seen"] += chunk.n_time
        found = Estimates(means, variances, sums, supply[:, due], every)
        lost = np.isnan(means[:, :, 0])
        return moved, Trace(
            moved["start_time"] + (n_before + due) / frequency,
            {name: np.where(lost, np.nan, values) for name, values in self.read(found).items()},
        )

    def information(self, records: RecordBatch) -> Information:
        """Information of the first record."""
        state, _ = self.step(self.start(records), records)
        return plant_information(self.options, records, self.first_covariance(state))

    def first_covariance(self, state: State) -> Array:
        """Covariance of the first record, shape (N_STATE, N_STATE)."""
        return np.asarray(state["covariance"][0])

    def follow(
        self, state: dict[str, NDArray[Any]], n_before: int, samples: tuple[Array, Array, Array],
        tuning: Tuning, every: int, found: tuple[Array, Array, Array],
    ) -> None:  # fmt: skip
        """Advance the filters in place, and fill means, variances and sums at the instants that are due."""
        streams = Streams(**{name: state[name] for name in Streams._fields})
        follow(streams, n_before, *samples, tuning, every, *found, workspace(self.options.substeps))

    @abstractmethod
    def read(self, found: Estimates) -> Mapping[str, Array]:
        """`estimates` over time, each (n_record, n_instant)."""

    def _tuning(self, chunk: RecordBatch) -> Tuning:
        options, frequency = self.options, chunk.sampling_frequency
        return Tuning(
            options.plant,
            1.0 / (frequency * options.substeps),
            options.spool_transition(frequency),
            options.spool == "command",
            options.prior_variances(chunk),
            options.walk_variances(frequency),
            options.sensor_variances,
            options.limits,
            1e3 * options.null_zone,
            1e3 * options.largest_travel,
        )
