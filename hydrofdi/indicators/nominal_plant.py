"""Assumptions of state estimators about the motion of the actuator."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from hydrofdi.estimation.plant import Plant
from hydrofdi.estimation.spool_path import Array, spool_transition
from hydrofdi.indicators.plant_constants import PlantConstant
from hydrofdi.indicators.uncertain_actuator import UncertainActuator
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.settings.quantities import SI

_OF_FRICTION = PlantConstant("friction", ("model",))


class NominalPlant(UncertainActuator):
    """An uncertain actuator whose motion is predicted from one sample to the next."""

    spool: Literal["command", "measured"] = "command"
    """Spool position. ``command``: computed from the input voltage, held between samples, with the nominal
    valve. ``measured``: interpolated linearly between its measured positions."""

    supply: Literal["auto", "measured", "nominal"] = "auto"
    """Initial supply pressure of the estimate. ``measured``: its channel. ``nominal``:
    ``supply_pressure``. ``auto``: measured if available, else nominal."""

    load_stiffness: Annotated[float, SI("N/m", above=0, most=1e12), PlantConstant()] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m]."""

    mass: Annotated[float, SI("kg", above=0, most=1e6), PlantConstant()] = 12.3
    """Mass m of piston and load [kg]."""

    friction: Literal["random_walk", "model"] = "random_walk"
    """Resisting force on the piston. ``random_walk``: an estimated force for friction and load together.
    ``model``: the nominal friction plus such a force."""

    coulomb_friction: Annotated[float, SI("N", least=0), _OF_FRICTION] = 200.0
    """Coulomb friction F_c [N], for ``friction: model``."""

    breakaway_friction: Annotated[float, SI("N", least=0), _OF_FRICTION] = 250.0
    """Breakaway friction F_brk [N], for ``friction: model``."""

    viscous_friction: Annotated[float, SI("N*s/m", least=0), _OF_FRICTION] = 50.0
    """Coefficient f of viscous friction [N·s/m], for ``friction: model``."""

    friction_transition: Annotated[float, SI("s/m", least=0), _OF_FRICTION] = 40.0
    """Coefficient c_v of the transition from breakaway to Coulomb friction [s/m], for ``friction: model``."""

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
        has_it = Channel.SUPPLY_PRESSURE in records.channels.keys() - records.relative
        return self.supply == "measured" or (self.supply == "auto" and has_it)
