"""Base of the Kalman filter indicators, extended or unscented: one filter per record."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hydrofdi.compilation.object_code import kernel
from hydrofdi.indicators.contract import RecursiveIndicator, RecursiveOptions
from hydrofdi.indicators.estimation import ekf, ukf
from hydrofdi.indicators.estimation.ekf import correct, predict
from hydrofdi.indicators.estimation.plant import (
    N_MEASURED,
    N_STATE,
    PER_MINUTE,
    STATES,
    Plant,
    Tuning,
    find_path,
    spool_transition,
)
from hydrofdi.indicators.estimation.ukf import correct_unscented, predict_unscented
from hydrofdi.indicators.nominal_actuator import UncertainActuator
from hydrofdi.physics import equation
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.data_sheet import MachineSheet, PlantConstant
from hydrofdi.settings.quantities import SI

N_SUM = 4
"""Number of sums over the samples since the last estimate: ν²/s; ν² of the pressures [MPa²]; dν/s and d²/s,
with d the signature: the change of innovation ν from a leak of 1 L/min since the start."""


class Streams(NamedTuple):
    """State of the filters of all streams.

    `mean` (n_stream, n_state) is NaN if the filter diverged; `covariance`, of an unscented filter its root;
    `sums` (n_stream, N_SUM), of an unscented filter the first; `spool`: position and velocity of the nominal
    spool [mm, mm/s].
    """

    mean: Array
    covariance: Array
    sums: Array
    spool: Array


def new_streams(n_stream: int, n_state: int) -> Streams:
    """Allocate the state of filters."""
    shapes = (n_state,), (n_state, n_state), (N_SUM,), (2,)
    return Streams(*(np.zeros((n_stream, *shape)) for shape in shapes))


@equation
def begin(mean: Array, covariance: Array, measured: Array, prior: Array) -> None:
    """Initialise a filter at its first sample: at rest at the measured position."""
    for i in range(mean.size):
        mean[i] = measured[i] if i < N_MEASURED else 0.0
        for j in range(mean.size):
            covariance[i, j] = prior[i] if i == j else 0.0


@equation
def variance(covariance: Array, spread: float | None, i: int) -> float:
    """Variance of an estimate from the covariance, or from its root."""
    total = covariance[i, i]
    if spread is not None:
        total = 0.0
        for j in range(covariance.shape[1]):
            total += covariance[i, j] * covariance[i, j]
    return total  # type: ignore[no-any-return]


@equation
def give_up_unless_sound(mean: Array, covariance: Array, limits: Array, spread: float | None) -> None:
    """Set an estimate to NaN if it exceeds physical limits, or a variance is negative or not finite."""
    sound = True
    for i in range(mean.size):
        sound &= abs(mean[i]) <= limits[i]
        sound &= 0.0 <= variance(covariance, spread, i) < np.inf
    if not sound:
        for i in range(mean.size):
            mean[i] = np.nan


@kernel
def follow(
    streams: Streams, measured: Array, drive: Array, supply: Array, tuning: Tuning, every: int,
    means: Array, variances: Array, sums: Array, signature: Array | None, spread: float | None, work: Any,
) -> None:  # fmt: skip
    """Process records from the zero state of their streams, which is updated in place.

    `measured` (n_stream, n_sample, N_MEASURED): P_1, P_2 [MPa] and x_p [mm]; `drive` (n_stream, n_sample):
    static spool position under the command, or the measured one [mm]; `supply` [MPa]. `means`, `variances`
    (n_stream, n_estimate, N_STATE) and `sums` (…, N_SUM) since the estimate before are filled after every
    `every` samples.

    Extended filters have a `signature` (n_stream, N_STATE), the error of the estimates per L/min of leakage
    that they do not model; unscented ones a `spread` of the sigma points, in √n standard deviations. The
    other is None; `work` is the workspace of the filter.
    """
    for k in range(measured.shape[0]):
        mean, covariance, own = streams.mean[k], streams.covariance[k], streams.sums[k]
        spool = streams.spool[k]
        for t in range(measured.shape[1]):
            if t == 0:
                begin(mean, covariance, measured[k, t], tuning.prior)
                spool[0], spool[1] = drive[k, t], 0.0
            else:
                is_open = find_path(spool, drive[k, t - 1], drive[k, t], tuning, work.path)
                if signature is not None:
                    predict(mean, covariance, signature[k], supply[k, t - 1], tuning, work)
                    correct(mean, covariance, signature[k], own, measured[k, t], is_open, tuning, work)
                if spread is not None:
                    predict_unscented(mean, covariance, spread, supply[k, t - 1], tuning, work)
                    own[0] += correct_unscented(mean, covariance, measured[k, t], is_open, tuning, work)
                give_up_unless_sound(mean, covariance, tuning.limits, spread)
            if (t + 1) % every == 0:
                estimate = t // every
                for i in range(mean.size):
                    means[k, estimate, tuning.places[i]] = mean[i]
                    variances[k, estimate, tuning.places[i]] = variance(covariance, spread, i)
                for j in range(own.size):
                    sums[k, estimate, j], own[j] = own[j], 0.0


class NominalPlant(UncertainActuator, MachineSheet):
    """An uncertain actuator whose motion is predicted from one sample to the next."""

    spool: Literal["command", "measured"] = "command"
    """Spool position. ``command``: computed from the input voltage, held between samples, with the nominal
    valve. ``measured``: interpolated linearly between its measured positions."""

    supply: Literal["auto", "measured", "nominal"] = "auto"
    """Initial supply pressure of the estimate. ``measured``: its channel. ``nominal``:
    ``supply_pressure``. ``auto``: measured if available, else nominal."""

    load_stiffness: Annotated[float, SI("N/m", least=0, most=1e12), PlantConstant()] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m]."""

    clearance_deviation: Annotated[float, SI("m^3/(s*Pa)", least=0, most=1.0)] = 1e-14
    """Standard deviation of the conductance of the clearance at each valve edge [m³/(s·Pa)]; not from the
    null leakage, because a clearance as free as that makes K_i scatter more."""

    friction: Literal["random_walk", "model"] = "random_walk"
    """Resisting force on the piston. ``random_walk``: an estimated force for friction and load together.
    ``model``: the nominal friction plus such a force."""

    velocity_threshold: Annotated[float, SI("m/s", above=0)] = 10e-3
    """Speed v_th below which dry friction is linear [m/s], for ``friction: model``; larger than that of a
    real actuator, so that the substeps can resolve it."""

    substeps: Annotated[int, Field(strict=True, ge=1, le=100)] = 4
    """Runge-Kutta steps per sample; at 500 Hz, four steps of 0.5 ms."""

    reference_pressure: Annotated[float, SI("Pa", least=1e4, most=2e8)] = 8e6
    """Pressure difference at which leakage flows are stated [Pa]."""

    @model_validator(mode="after")
    def _breakaway_is_largest(self) -> NominalPlant:
        if self.breakaway_friction < self.coulomb_friction:
            raise ValueError("breakaway_friction is less than coulomb_friction")
        return self

    @property
    def plant(self) -> Plant:
        """Nominal parameters in estimator units."""
        (area_1, area_2), (volume_1, volume_2) = self.areas, self.volumes
        return Plant(
            mass=1e-3 * self.mass,
            area_1=1e6 * area_1,
            area_2=1e6 * area_2,
            volume_1=1e9 * volume_1,
            volume_2=1e9 * volume_2,
            stiffness=1e-3 * self.load_stiffness,
            bulk_modulus=1e-6 * self.bulk_modulus,
            ret=1e-6 * self.return_pressure,
            reference_pressure=1e-6 * self.reference_pressure,
            flow_gain=1e6 * self.flow_gain,
            area_gradient=1e3 * self.area_gradient,
            coulomb=self.coulomb_friction,
            breakaway=self.breakaway_friction,
            viscous=1e-3 * self.viscous_friction,
            transition=1e-3 * self.friction_transition,
            velocity_threshold=1e3 * self.velocity_threshold,
            has_friction_model=True if self.friction == "model" else None,
        )

    def spool_transition(self, sampling_frequency: float) -> Array:
        """State transition matrix of the spool over half a Runge-Kutta step, shape (2, 2)."""
        half_step = 0.5 / (sampling_frequency * self.substeps)
        return spool_transition(2.0 * np.pi * self.natural_frequency, self.damping_ratio, half_step)

    def spool_drive(self, records: RecordBatch) -> Array:
        """Static spool position under the command, or the measured one [mm], shape (n_record, n_time)."""
        if self.spool == "measured":
            return 1e3 * records[Channel.SPOOL_POSITION]
        return 1e3 * self.spool_gain * records[Channel.INPUT_VOLTAGE]

    def supply_of(self, records: RecordBatch) -> Array:
        """Measured or nominal supply pressure [MPa], shape (n_record, n_time)."""
        if self.measures_supply(records):
            return 1e-6 * records[Channel.SUPPLY_PRESSURE]
        any_channel = next(iter(records.channels.values()))
        return np.full(any_channel.shape, 1e-6 * self.supply_pressure)

    def measures_supply(self, records: RecordBatch) -> bool:
        """Whether the supply pressure is measured."""
        return self.supply_known_by(records) == "measured"


Parameter = Literal[
    "leakage", "bulk_modulus", "supply", "flow_gain", "offset", "lap", "clearance", "bias_1", "bias_2"
]

MOTION = frozenset({"pressure_1", "pressure_2", "position", "velocity", "resistance"})
"""States that every filter has."""

LITRE_PER_MINUTE = 1e-9 * PER_MINUTE
"""1 L/min [m³/s]."""

LARGEST = {
    "pressure_1": 100.0, "pressure_2": 100.0, "position": 1e4, "velocity": 1e5, "resistance": 1e6,
    "leakage": 100.0, "bulk_modulus": 3.0, "supply": 1.0, "flow_gain": 0.9, "offset": 100.0, "lap": 100.0,
    "clearance": 1e4, "bias_1": 10.0, "bias_2": 10.0,
}  # fmt: skip
"""Absolute value of each state beyond which an estimate is not physical, in estimator units."""


class KalmanOptions(NominalPlant, RecursiveOptions):
    """Assumptions of a Kalman filter of the nominal plant.

    A walk is the standard deviation that a random walk adds within one second.
    """

    states: tuple[Parameter, ...] = get_args(Parameter)
    """Parameters estimated in addition to both pressures, position, velocity and friction; the others are
    nominal. ``[leakage]`` gives six states, with ``bulk_modulus`` seven, with ``supply`` and ``flow_gain``
    nine, with ``offset`` and ``lap`` eleven, with ``clearance`` twelve, with ``bias_1`` and ``bias_2``, the
    constant errors of the pressure sensors, fourteen."""

    leakage_deviation: Annotated[float, SI("m^3/s", above=0)] = 0.3 * LITRE_PER_MINUTE
    """Prior standard deviation of the leakage at the reference pressure, about zero [m³/s]."""

    friction_deviation: Annotated[float, SI("N", least=0)] = 300.0
    """Prior standard deviation of friction and load, about zero or the model [N]."""

    velocity_deviation: Annotated[float, SI("m/s", above=0)] = 50e-3
    """Prior standard deviation of the velocity, about rest [m/s]."""

    pressure_walk: Annotated[float, SI("Pa", least=0)] = 45e3
    """Random walk of each pressure in addition to the plant model [Pa]; 2 kPa in 2 ms. A smaller value relies
    too much on the model if machines differ; a larger one makes the leakage less precise."""

    velocity_walk: Annotated[float, SI("m/s", least=0)] = 11e-3
    """Random walk of the velocity in addition to the plant model [m/s]; 0.5 mm/s in 2 ms."""

    friction_walk: Annotated[float, SI("N", least=0)] = 4.5e3
    """Walk of friction and load [N]; 200 N in 2 ms. They reverse abruptly with the motion."""

    leakage_walk: Annotated[float, SI("m^3/s", least=0)] = 2.2e-4 * LITRE_PER_MINUTE
    """Walk of the leakage [m³/s]; 1e-5 L/min in 2 ms. A larger value follows the onset of a leak sooner, but
    is less precise."""

    bulk_modulus_walk: Annotated[float, SI("1", least=0)] = 4.5e-4
    """Walk of ln β [-]; 2e-5 in 2 ms."""

    supply_walk: Annotated[float, SI("1", least=0)] = 4.5e-5
    """Walk of ln P_s [-]; 2e-6 in 2 ms."""

    flow_gain_walk: Annotated[float, SI("1", least=0)] = 4.5e-5
    """Walk of the flow gain relative to its nominal value [-]; 2e-6 in 2 ms."""

    offset_walk: Annotated[float, SI("m", least=0)] = 0.22e-9
    """Walk of the spool position at which the valve is closed [m]; 0.01 nm in 2 ms."""

    lap_walk: Annotated[float, SI("m", least=0)] = 0.22e-9
    """Walk of the lap [m]; 0.01 nm in 2 ms."""

    clearance_walk: Annotated[float, SI("m^3/(s*Pa)", least=0)] = 0.0
    """Walk of the conductance of the clearance [m³/(s·Pa)]."""

    pressure_noise: Annotated[float, SI("Pa", above=0)] = 15e3
    """Standard deviation of the noise of each pressure sensor assumed by the filter [Pa]. It is deliberately
    three times that of usual sensors: a filter that follows the noise underestimates β (for this bias see
    Ljung, IEEE Trans. Automatic Control 24 (1979))."""

    position_noise: Annotated[float, SI("m", above=0)] = 10e-6
    """Standard deviation of the noise of the position sensor [m]."""

    null_zone: Annotated[float, SI("m", least=0)] = 2e-6
    """Distance of the spool from its centre within which parameters are not updated [m]: there the flow
    depends on offset, lap and clearance. Their variances still enter the gain (considered parameters)."""

    largest_travel: Annotated[float, SI("m", above=0)] = 5e-6
    """Travel of the spool between two samples above which parameters are not updated [m]: no valve is exactly
    as fast as the nominal one."""

    def measured_states(self, records: RecordBatch) -> Array:
        """P_1, P_2 [MPa] and x_p [mm], shape (n_record, n_time, 3)."""
        first, second = records[Channel.CHAMBER_1_PRESSURE], records[Channel.CHAMBER_2_PRESSURE]
        return np.stack((1e-6 * first, 1e-6 * second, 1e3 * self.position(records)), axis=2)

    @property
    def estimated(self) -> frozenset[str]:
        """States that are estimated rather than fixed at nominal values."""
        return MOTION | frozenset(self.states)

    @property
    def places(self) -> NDArray[np.int64]:
        """Indices of the estimated states in ``STATES``."""
        return np.array([index for index, name in enumerate(STATES) if name in self.estimated])

    def prior_variances(self, records: RecordBatch) -> Array:
        """Prior variance of each of ``STATES``, in estimator units."""
        usual = 2e-3 if self.measures_supply(records) else 0.03
        supply = usual if self.supply_deviation is None else self.supply_deviation
        return self._variances("deviation", _PRIORS, supply=supply)

    def walk_variances(self, sampling_frequency: float) -> Array:
        """Process noise variance per sample of each of ``STATES``, in estimator units."""
        constant = {"position": 0.0, "bias_1": 0.0, "bias_2": 0.0}
        return self._variances("walk", _WALKS, **constant) / sampling_frequency

    @property
    def limits(self) -> Array:
        """Largest physical absolute value of each of ``STATES``, in estimator units."""
        plant = self.plant
        half_stroke = min(plant.volume_1 / plant.area_1, plant.volume_2 / plant.area_2)
        return np.array([(LARGEST | {"position": half_stroke})[name] for name in STATES])

    def _variances(self, kind: str, options: Mapping[str, str], **given: float) -> Array:
        """Squares of the options of a kind, or of values that are given, for the estimated states."""
        variances = np.zeros(N_STATE)
        for index, name in enumerate(STATES):
            if name in self.estimated:
                value = given.get(name, getattr(self, options.get(name, f"{name}_{kind}"), 0.0))
                per_unit = value / LITRE_PER_MINUTE if name == "leakage" else _PER_SI.get(name, 1.0) * value
                variances[index] = per_unit**2
        return variances


_WALKS = {"pressure_1": "pressure_walk", "pressure_2": "pressure_walk", "resistance": "friction_walk"}
_PRIORS = {
    "pressure_1": "pressure_noise", "pressure_2": "pressure_noise", "position": "position_noise",
    "resistance": "friction_deviation", "bias_1": "pressure_bias", "bias_2": "pressure_bias",
}  # fmt: skip
"""State → option with its deviation, where that does not have the name of the state."""

_PER_SI = {
    "pressure_1": 1e-6, "pressure_2": 1e-6, "position": 1e3, "velocity": 1e3, "offset": 1e6, "lap": 1e6,
    "clearance": 1e15, "bias_1": 1e-6, "bias_2": 1e-6,
}  # fmt: skip
"""State → factor from SI to estimator units, where it is not 1, but for the leakage."""

Chosen = TypeVar("Chosen", bound=KalmanOptions)


@dataclass(frozen=True)
class FilterEstimates:
    """Estimates of a filter at some instants, in estimator units.

    `means` and `variances` (n_record, n_instant, N_STATE); `sums` (…, N_SUM) over the `n_sample` samples
    since the previous instant; nominal or measured `supply` (n_record, n_instant) [MPa].
    """

    means: Array
    variances: Array
    sums: Array
    supply: Array
    n_sample: int


class KalmanFilter(RecursiveIndicator[Chosen]):
    """Base of indicators from the estimates, variances and innovations of a Kalman filter.

    It is unscented if its options state the spread of the sigma points.
    """

    absence = "the filter diverged, or a sample is not a number"
    is_cheap = False

    def follow(self, records: RecordBatch, due: NDArray[np.intp]) -> Mapping[str, Array]:
        """Filter the records."""
        every, shape = self.samples_per_estimate(records.sampling_frequency), (records.n_record, due.size)
        means, variances = np.zeros((*shape, N_STATE)), np.zeros((*shape, N_STATE))
        sums, supply = np.zeros((*shape, N_SUM)), self.options.supply_of(records)
        options, tuning, signature = self.options, self.tuning(records), None
        spread: float | None = getattr(options, "spread", None)
        if spread is None:
            work: Any = ekf.workspace(options.substeps)
            signature = np.zeros((records.n_record, N_STATE))
        else:
            tuning = tuning.of_roots(options.places)
            work = ukf.workspace(tuning.places.size, options.substeps)
        follow(
            new_streams(records.n_record, tuning.places.size), options.measured_states(records),
            options.spool_drive(records), supply, tuning, every, means, variances, sums, signature, spread,
            work,
        )  # fmt: skip
        estimates = FilterEstimates(means, variances, sums, supply[:, due], every)
        lost = np.isnan(means[:, :, 0])
        return {name: np.where(lost, np.nan, values) for name, values in self.read(estimates).items()}

    @abstractmethod
    def read(self, estimates: FilterEstimates) -> Mapping[str, Array]:
        """`estimates` over time, each (n_record, n_instant)."""

    def tuning(self, records: RecordBatch) -> Tuning:
        """Known parameters for the records."""
        options, frequency = self.options, records.sampling_frequency
        pressure_noise = 1e-6 * options.pressure_noise
        return Tuning(
            options.plant,
            1.0 / (frequency * options.substeps),
            options.spool_transition(frequency),
            options.spool == "command",
            options.prior_variances(records),
            options.walk_variances(frequency),
            np.array([pressure_noise, pressure_noise, 1e3 * options.position_noise]) ** 2,
            options.limits,
            np.arange(N_STATE),
            1e3 * options.null_zone,
            1e3 * options.largest_travel,
        )
