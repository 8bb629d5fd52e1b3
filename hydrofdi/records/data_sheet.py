"""Data sheet of a machine: the constants that indicators with a model of the actuator need."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import model_validator

from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.messages import shown_quantity
from hydrofdi.settings.quantities import SI, Section, field_quantity


@dataclass(frozen=True)
class PlantConstant:
    """Annotation of an option that describes the plant.

    Attributes
    ----------
    option : str
        The constant is used only if this option has one of the `values`; always if empty.
    parameter : str
        Dotted parameter of a simulated plant with the same meaning.
    """

    option: str = ""
    values: tuple[Any, ...] = ()
    parameter: str = ""

    def is_used(self, options: Section) -> bool:
        """Whether the indicator uses the constant with these options."""
        return not self.option or getattr(options, self.option, None) in self.values


def _of(parameter: str) -> PlantConstant:
    return PlantConstant(parameter=parameter)


def _of_friction(parameter: str) -> PlantConstant:
    return PlantConstant("friction", ("model",), f"friction.{parameter}")


class DataSheet(Section):
    """Cylinder, fluid, valve and supply; the defaults are those of the paper."""

    piston_area: Annotated[float, SI("m^2", least=1e-7, most=1.0), _of("actuator.piston_area")] = 633e-6
    """Annular area A of the piston in chamber 1 [m²]."""

    piston_area_2: Annotated[
        Annotated[float, SI("m^2", least=1e-7, most=1.0)] | None, _of("actuator.piston_area_2")
    ] = None
    """The same for chamber 2 [m²]; by default that of chamber 1."""

    chamber_volume: Annotated[float, SI("m^3", least=1e-8, most=1.0), _of("actuator.chamber_volume")] = 280e-6
    """Volume V of chamber 1 with the piston at the centre, which is position zero by default [m³]."""

    chamber_volume_2: Annotated[
        Annotated[float, SI("m^3", least=1e-8, most=1.0)] | None, _of("actuator.chamber_volume_2")
    ] = None
    """The same for chamber 2 [m³]; by default that of chamber 1 in the ratio of the areas."""

    position_zero: Literal["centre", "retracted", "extended"] = "centre"
    """Where the measured position is zero. A positive position enlarges chamber 1. ``retracted``: at the end
    of the stroke with the smallest chamber 1; ``extended``: at that with the largest."""

    stroke: Annotated[Annotated[float, SI("m", above=0, most=100.0)] | None, _of("actuator.stroke")] = None
    """Stroke of the piston [m], for ``position_zero: retracted`` or ``extended``."""

    bulk_modulus: Annotated[float, SI("Pa", least=1e7, most=1e10), _of("fluid.bulk_modulus")] = 551e6
    """Bulk modulus β of the fluid [Pa]."""

    load_stiffness: Annotated[
        float, SI("N/m", least=0, most=1e12), PlantConstant("chambers", (1,), "actuator.load_stiffness")
    ] = 150e3
    """Stiffness K_ex of the spring that loads the piston [N/m], used in place of the position."""

    flow_gain: Annotated[float, SI("m^1.5/kg^0.5", above=0, most=1.0), _of("valve.flow_gain")] = 0.0292
    """Flow gain K_v of the valve [m^1.5/kg^0.5]."""

    area_gradient: Annotated[float, SI("m", above=0, most=10.0), _of("valve.area_gradient")] = 20.75e-3
    """Orifice area gradient w [m]."""

    spool_gain: Annotated[
        float, SI("m/V", above=0, most=1.0), PlantConstant("spool", ("command", "square"), "valve.spool_gain")
    ] = 22e-6
    """Spool position gain k_v [m/V], for ``spool: command``."""

    natural_frequency: Annotated[
        float, SI("Hz", least=0.1, most=1e5), PlantConstant("spool", ("command",), "valve.natural_frequency")
    ] = 175.0
    """Undamped natural frequency of the spool [Hz], for ``spool: command``."""

    damping_ratio: Annotated[
        float, SI("1", least=0.01, most=100.0), PlantConstant("spool", ("command",), "valve.damping_ratio")
    ] = 0.7
    """Damping ratio ξ of the spool [-], for ``spool: command``."""

    null_leakage: Annotated[float, SI("m^3/s", least=0, most=1.0)] | None = None
    """Largest null leakage q_0 of the valve at the supply pressure, as its data sheet states it [m³/s], for
    balances; by default 3 % of the flow at 10 V and 35 bar per edge."""

    supply_pressure: Annotated[
        float, SI("Pa", least=1e4, most=2e8), PlantConstant("supply", ("nominal",), "supply.pressure")
    ] = 17.2e6
    """Nominal supply pressure P_s [Pa]."""

    return_pressure: Annotated[float, SI("Pa", least=0, most=2e8), _of("supply.return_pressure")] = 0.0
    """Return pressure P_r [Pa]."""

    @model_validator(mode="after")
    def _has_stroke(self) -> Self:
        if self.position_zero != "centre" and self.stroke is None:
            raise ValueError(f"position_zero: {self.position_zero} needs the stroke of the piston")
        return self

    @property
    def areas(self) -> tuple[float, float]:
        """Piston areas of both chambers [m²]."""
        return self.piston_area, self.piston_area if self.piston_area_2 is None else self.piston_area_2

    @property
    def rated_flow(self) -> float:
        """Flow of the valve at 10 V and 35 bar per edge [m³/s]."""
        return self.flow_gain * self.area_gradient * self.spool_gain * 10.0 * math.sqrt(35e5)

    @property
    def volumes(self) -> tuple[float, float]:
        """Volumes of both chambers with the piston at the centre [m³]."""
        (first, second), volume = self.areas, self.chamber_volume
        return volume, self.chamber_volume_2 or volume * (second / first)

    def position(self, records: RecordBatch) -> Array:
        """x_p from the centre [m], shape (n_record, n_time); NaN where a chamber would have no volume."""
        position = self._from_centre(records)
        first, second = self._volumes_at(position)
        is_impossible = (first <= self._no_volume) | (second <= self._no_volume)
        return np.where(is_impossible, np.nan, position) if is_impossible.any() else position

    def unfit_positions(self, records: RecordBatch) -> list[str | None]:
        """Why the positions of each record are impossible: a chamber would have no volume; None if it has."""
        if Channel.PISTON_POSITION not in records.channels:
            return [None] * records.n_record
        reasons: list[str | None] = [None] * records.n_record
        if self.stroke is not None:
            travel = np.ptp(records[Channel.PISTON_POSITION], axis=1)
            for row in np.flatnonzero(travel > (1.0 + 1e-9) * self.stroke).tolist():
                reasons[row] = f"the piston travels {travel[row]:.3g} m, but its stroke is {self.stroke:g} m"
        for chamber, volume in enumerate(self._volumes_at(self._from_centre(records)), start=1):
            for row in np.flatnonzero(np.any(volume <= self._no_volume, axis=1)).tolist():
                reasons[row] = (
                    f"the volume of chamber {chamber} would be {1e6 * np.nanmin(volume[row]):.4g} cm^3:"
                    " state 'position_zero' and 'stroke', or the chamber volumes at position zero"
                )
        return reasons

    @property
    def _no_volume(self) -> float:
        """Volume that may be the rounding of zero, at the end of a stroke without dead volume [m³]."""
        return 1e-9 * self.chamber_volume

    @property
    def _zero(self) -> float:
        """Distance of the measured zero from the centre [m]."""
        return {"centre": 0.0, "retracted": -0.5, "extended": 0.5}[self.position_zero] * (self.stroke or 0.0)

    @property
    def ranges(self) -> dict[Channel, tuple[float, float]]:
        """Values that a stated stroke and supply pressure allow [SI], with room for errors of sensors."""
        known = {}
        if self.stroke is not None:
            known[Channel.PISTON_POSITION] = -0.51 * self.stroke - self._zero, 0.51 * self.stroke - self._zero
        if "supply_pressure" in self.model_fields_set:
            pressures = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.SUPPLY_PRESSURE
            known |= dict.fromkeys(pressures, (-1e5, 1.2 * self.supply_pressure))
        return known

    def _from_centre(self, records: RecordBatch) -> Array:
        position = records[Channel.PISTON_POSITION]
        return position + self._zero if self._zero else position

    def _volumes_at(self, position: Array) -> tuple[Array, Array]:
        (area_1, area_2), (first, second) = self.areas, self.volumes
        return first + area_1 * position, second - area_2 * position


class MachineSheet(DataSheet):
    """Data sheet of a measured machine. What is not stated has the value of the paper."""

    mass: Annotated[float, SI("kg", above=0, most=1e6), _of("actuator.mass")] = 12.3
    """Mass m of piston and load [kg]."""

    coulomb_friction: Annotated[float, SI("N", least=0), _of_friction("coulomb")] = 200.0
    """Coulomb friction F_c [N], for ``friction: model``."""

    breakaway_friction: Annotated[float, SI("N", least=0), _of_friction("breakaway")] = 250.0
    """Breakaway friction F_brk [N], for ``friction: model``."""

    viscous_friction: Annotated[float, SI("N*s/m", least=0), _of_friction("viscous")] = 50.0
    """Coefficient f of viscous friction [N·s/m], for ``friction: model``."""

    friction_transition: Annotated[float, SI("s/m", least=0), _of_friction("transition")] = 40.0
    """Coefficient c_v of the transition from breakaway to Coulomb friction [s/m], for ``friction: model``."""


class StatedMachine(MachineSheet):
    """Data sheet of a machine, and how wrong a balance of it may be."""

    error: Annotated[float, SI("m^3", above=0)] | None = None
    """Standard deviation of the residual of a window's balance [m³]; by default that of the indicator."""

    pressure_bias: Annotated[float, SI("Pa", least=0, most=2e8)] | None = None
    """Standard deviation of the constant error of each pressure sensor [Pa]; by default that of the
    indicator."""

    @property
    def given(self) -> dict[str, Any]:
        """Option of an indicator → its value, for all that is stated."""
        return {
            name: getattr(self, name) for name in StatedMachine.model_fields if name in self.model_fields_set
        }


def is_other(one: Any, other: Any) -> bool:
    """Whether two values of a constant differ by more than rounding on a data sheet."""
    are_numbers = isinstance(one, float) and isinstance(other, float)
    return not math.isclose(one, other, rel_tol=1e-3) if are_numbers else bool(one != other)


def data_sheet_lines(values: Mapping[str, Any]) -> Iterator[str]:
    """A description's section for a data sheet."""
    yield "actuator:"
    for name, value in values.items():
        quantity = field_quantity(StatedMachine.model_fields[name])
        shown = shown_quantity(value, quantity.unit) if quantity and isinstance(value, float) else value
        yield f"  {name}: {'null' if shown is None else shown}"


def usual_sheet_lines() -> Iterator[str]:
    """The same with the numbers of the paper, as comments."""
    yield "# for balances and observers: your data sheet; these are the numbers of another machine"
    usual = {name: info.default for name, info in StatedMachine.model_fields.items()}
    yield from (f"# {line}" for line in data_sheet_lines(usual))


PLANT_PARAMETERS = {
    name: mark.parameter
    for name, info in MachineSheet.model_fields.items()
    for mark in info.metadata
    if isinstance(mark, PlantConstant)
} | {"drive_amplitude": "input.amplitude"}
"""Constant → dotted parameter of a simulated plant with the same meaning."""
