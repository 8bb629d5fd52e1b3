"""Common options of the Kalman filters: states, their prior deviations, random walks and noise."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import field_validator

from hydrofdi.estimation.plant import PER_MINUTE, STATES
from hydrofdi.indicators.nominal_plant import NominalPlant
from hydrofdi.indicators.recursive import RecursiveOptions
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

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


MEASURED = (Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION)
"""Measured channels of a filter."""


class KalmanOptions(NominalPlant, RecursiveOptions):
    """Assumptions of a Kalman filter of the nominal plant.

    A walk is the standard deviation that a random walk adds within one second.
    """

    states: tuple[Parameter, ...] = (
        "leakage", "bulk_modulus", "supply", "flow_gain", "offset", "lap", "clearance", "bias_1", "bias_2",
    )  # fmt: skip
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

    @field_validator("states")
    @classmethod
    def _each_state_once(cls, states: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
        if len(set(states)) < len(states):
            raise ValueError("a state is named twice")
        return states

    def measured_states(self, records: RecordBatch) -> Array:
        """P_1, P_2 [MPa] and x_p [mm], shape (n_record, n_time, 3)."""
        first, second, _ = MEASURED
        return np.stack((1e-6 * records[first], 1e-6 * records[second], 1e3 * self.position(records)), axis=2)

    @property
    def estimated(self) -> frozenset[str]:
        """States that are estimated rather than fixed at nominal values."""
        return MOTION | frozenset(self.states)

    def prior_variances(self, records: RecordBatch) -> Array:
        """Prior variance of each of ``STATES``, in estimator units."""
        usual = 2e-3 if self.measures_supply(records) else 0.03
        return self._variances(
            pressure_1=1e-6 * self.pressure_noise,
            pressure_2=1e-6 * self.pressure_noise,
            position=1e3 * self.position_noise,
            velocity=1e3 * self.velocity_deviation,
            resistance=self.friction_deviation,
            leakage=self.leakage_deviation / LITRE_PER_MINUTE,
            bulk_modulus=self.bulk_modulus_deviation,
            supply=usual if self.supply_deviation is None else self.supply_deviation,
            flow_gain=self.flow_gain_deviation,
            offset=1e6 * self.offset_deviation,
            lap=1e6 * self.lap_deviation,
            clearance=1e15 * self.clearance_deviation,
            bias_1=1e-6 * self.pressure_bias,
            bias_2=1e-6 * self.pressure_bias,
        )

    def walk_variances(self, sampling_frequency: float) -> Array:
        """Process noise variance per sample of each of ``STATES``, in estimator units."""
        in_a_second = self._variances(
            pressure_1=1e-6 * self.pressure_walk,
            pressure_2=1e-6 * self.pressure_walk,
            velocity=1e3 * self.velocity_walk,
            resistance=self.friction_walk,
            leakage=self.leakage_walk / LITRE_PER_MINUTE,
            bulk_modulus=self.bulk_modulus_walk,
            supply=self.supply_walk,
            flow_gain=self.flow_gain_walk,
            offset=1e6 * self.offset_walk,
            lap=1e6 * self.lap_walk,
            clearance=1e15 * self.clearance_walk,
        )
        return in_a_second / sampling_frequency

    @property
    def sensor_variances(self) -> Array:
        """Variances of P_1, P_2 and x_p [MPa², MPa², mm²]."""
        pressure = 1e-6 * self.pressure_noise
        return np.array([pressure, pressure, 1e3 * self.position_noise]) ** 2

    @property
    def limits(self) -> Array:
        """Largest physical absolute value of each of ``STATES``, in estimator units."""
        plant = self.plant
        half_stroke = min(plant.volume_1 / plant.area_1, plant.volume_2 / plant.area_2)
        return np.array([(LARGEST | {"position": half_stroke})[name] for name in STATES])

    def _variances(self, **deviations: float) -> Array:
        estimated = self.estimated
        return np.array([deviations.get(name, 0.0) ** 2 if name in estimated else 0.0 for name in STATES])
