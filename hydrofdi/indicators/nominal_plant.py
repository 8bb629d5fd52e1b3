"""Assumptions of state estimators: uncertainty of an actuator, and its motion."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from hydrofdi.indicators.estimation.plant import Plant, spool_transition
from hydrofdi.indicators.nominal_actuator import NominalActuator, PlantConstant
from hydrofdi.physics.valve import clearance_conductance
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.data_sheet import MachineSheet
from hydrofdi.settings.quantities import SI

Share = Annotated[float, SI("1", least=0, most=1e3)]

_USUAL_LEAKAGE = 0.03
"""Null leakage over rated flow of a valve of which neither is stated: the order of catalogue limits."""

_SUPPLY = {"measured": 2e-3, "sum": 0.02, "nominal": 0.04}


class UncertainActuator(NominalActuator):
    """A nominal actuator and prior standard deviations of its parameters; zero means exactly known."""

    bulk_modulus_deviation: Share = 0.3
    """Relative standard deviation of 1/β [-]."""

    chamber_volume_deviation: Share = 0.02
    """Relative standard deviation of the chamber volumes [-]. It is added in full to the deviation of β,
    because pressures determine only β/V. This is too wide if the estimated flow gain and lap absorb the
    volume error instead, as in balances under a square wave in open loop."""

    flow_gain_deviation: Share = 0.025
    """Relative standard deviation of the flow through the open valve [-]."""

    supply_deviation: Share | None = None
    """Relative standard deviation of the supply pressure [-]; by default 0.002 if measured, 0.04 if nominal,
    and 0.02 if from the pressures."""

    offset_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.5e-6
    """Standard deviation of the spool position at which the valve is closed, about zero [m]."""

    lap_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 0.6e-6
    """Standard deviation of the lap x_0 of the valve, about zero [m]."""

    clearance_deviation: Annotated[float, SI("m^3/(s*Pa)", least=0, most=1.0)] | None = None
    """Standard deviation of the conductance of the clearance at each valve edge, about zero [m³/(s·Pa)]; by
    default that of the null leakage, q_0/(P_s − P_r)."""

    edge_gain_deviation: Share = 0.03
    """Standard deviation of the gain of each metering edge relative to the others [-]."""

    edge_lap_deviation: Annotated[float, SI("m", least=0, most=1.0)] = 1.2e-6
    """Standard deviation of the lap of each metering edge relative to the others [m]."""

    return_deviation: Annotated[float, SI("Pa", least=0, most=2e8)] = 0.4e6
    """Standard deviation of the return pressure [Pa]."""

    free_air_deviation: Share = 0.01
    """Standard deviation of the volume share of free air at atmospheric pressure, about zero [-]."""

    supply_resistance_deviation: Annotated[float, SI("Pa*s/m^3", least=0, most=1e15)] = 2e9
    """Standard deviation of the drop of the supply pressure over the flow drawn, about zero [Pa·s/m³]."""

    pressure_bias: Annotated[float, SI("Pa", least=0, most=2e8)] = 25e3
    """Standard deviation of the constant error of each chamber pressure sensor [Pa]."""

    def bulk_modulus_error(self, modulus: Array, error: Array) -> Array:
        """Standard deviation of β [Pa], from the one that assumes nominal chamber volumes."""
        return np.asarray(np.hypot(error, self.chamber_volume_deviation * modulus))

    @property
    def largest_clearance(self) -> float:
        """Conductance of the clearance at each edge of a valve with the largest null leakage [m³/(s·Pa)]."""
        if self.clearance_deviation is not None:
            return self.clearance_deviation
        flow = _USUAL_LEAKAGE * self.rated_flow if self.null_leakage is None else self.null_leakage
        return clearance_conductance(flow, self.supply_pressure, self.return_pressure)

    def prior_deviations(self, records: RecordBatch, n_pressure: int) -> dict[str, float]:
        """Unknown → prior standard deviation; infinite for K_i. Known parameters are omitted."""
        usual = _SUPPLY[self.supply_known_by(records)]
        deviations = {
            "internal_coefficient": math.inf,
            "compressibility": self.bulk_modulus_deviation / self.bulk_modulus,
            "flow_gain": self.flow_gain_deviation,
            "supply": usual if self.supply_deviation is None else self.supply_deviation,
            "offset": self.offset_deviation,
            "lap": self.lap_deviation,
            "clearance": self.largest_clearance,
            "bias_1": self.pressure_bias,
            "bias_2": self.pressure_bias if n_pressure == 2 else 0.0,
            "return_pressure": self.return_deviation,
            "free_air": self.free_air_deviation,
            "supply_resistance": self.supply_resistance_deviation,
            "gain_by_direction": 0.5 * self.edge_gain_deviation,
            "gain_by_feeding": 0.5 * self.edge_gain_deviation,
            "gain_by_chamber": 0.5 * self.edge_gain_deviation if n_pressure == 2 else 0.0,
            "lap_by_feeding": 0.5 * self.edge_lap_deviation,
            "lap_by_chamber": 0.5 * self.edge_lap_deviation if n_pressure == 2 else 0.0,
        }
        return {name: deviation for name, deviation in deviations.items() if deviation > 0.0}


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
