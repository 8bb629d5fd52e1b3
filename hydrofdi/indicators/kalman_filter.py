"""Base of the Kalman filter indicators: one filter per record of a stream, and its information."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from hydrofdi.estimation.ekf_stream import N_SUM, Streams, Tuning, follow, workspace
from hydrofdi.estimation.plant import N_STATE, STATES
from hydrofdi.indicators.information import Information
from hydrofdi.indicators.kalman import LITRE_PER_MINUTE, MEASURED, MOTION, KalmanOptions
from hydrofdi.indicators.recursive import RecursiveIndicator, State, Trace, instants
from hydrofdi.records import Array, Channel, RecordBatch

_IN_SI = {
    "pressure_1": 1e6, "pressure_2": 1e6, "position": 1e-3, "velocity": 1e-3, "leakage": LITRE_PER_MINUTE,
    "offset": 1e-6, "lap": 1e-6, "clearance": 1e-15, "bias_1": 1e6, "bias_2": 1e6,
}  # fmt: skip
"""State → factor from estimator units to SI, where it is not 1."""

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
        prior = np.sqrt(self.options.prior_variances(records))
        (open_,) = np.nonzero(prior)
        names = [STATES[place] for place in open_]
        deviations = [prior[place] * _IN_SI.get(STATES[place], 1.0) for place in open_]
        covariance = self.first_covariance(state)[np.ix_(open_, open_)]
        relative = covariance / np.outer(prior[open_], prior[open_])
        return Information.of(names, deviations, relative, sum(name in MOTION for name in names))

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
