"""Actuator that an indicator assumes: data sheet, uncertainty, and how valve and supply are known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.records.data_sheet import DataSheet, PlantConstant
from hydrofdi.settings.quantities import SI, Section, field_quantity


def plant_constants(options: Section) -> dict[str, str]:
    """Plant constant used with these options → its SI unit."""
    constants = {}
    for name, info in type(options).model_fields.items():
        marks = [each for each in info.metadata if isinstance(each, PlantConstant)]
        if any(mark.is_used(options) for mark in marks):
            quantity = field_quantity(info)
            constants[name] = quantity.unit if quantity else "1"
    return constants


def constants_not_given(options: Section) -> tuple[str, ...]:
    """Plant constants that are used but were left at their defaults, unless that is nothing."""
    return tuple(
        name
        for name in plant_constants(options)
        if name not in options.model_fields_set and getattr(options, name)
    )


def assumption_text(label: str, names: Sequence[str]) -> str:
    """The sentence that names constants which nobody gave."""
    return (
        f"{label}: not given: {', '.join(names)}; the nominal actuator of the paper is assumed, so the"
        " numbers may be wrong for yours; state yours under 'actuator:' of the description"
        f" (docs/measured.md), or as options of {label}"
    )


_IF_STATED = {
    "position_zero": "", "null_leakage": "m^3/s", "supply_pressure": "Pa", "error": "m^3",
    "pressure_bias": "Pa",
}  # fmt: skip
"""Constants that nobody misses if they are not stated → SI unit."""


def sheet_constants(options: Section) -> dict[str, str]:
    """What the indicator takes from a data sheet, if it is not stated: constant → its SI unit."""
    own = type(options).model_fields
    return plant_constants(options) | {name: unit for name, unit in _IF_STATED.items() if name in own}


def from_sheet(options: Section, sheet: Mapping[str, Any]) -> dict[str, Any]:
    """What a data sheet states of the constants that are used with these options but not among them."""
    used = sheet_constants(options)
    return {name: sheet[name] for name in used if name in sheet and name not in options.model_fields_set}


class NominalActuator(DataSheet):
    """Nominal actuator with a critically lapped servovalve; defaults are those of the paper."""

    spool: Literal["measured", "command"] = "measured"
    """Spool position: ``measured``, or computed from the input voltage with the nominal valve
    (``command``)."""

    supply: Literal["auto", "measured", "nominal", "sum"] = "auto"
    """Supply pressure. ``measured``: its channel. ``nominal``: ``supply_pressure``. ``sum``: the
    median, of recursive indicators the running mean, of P_1 + P_2 minus the return pressure, which assumes a
    matched valve and equal areas; with one pressure, twice its mean minus the pressure that balances the
    spring.
    ``auto``: measured, else ``sum`` with equal areas, else nominal."""

    @property
    def channels(self) -> frozenset[Channel]:
        """Pressures, position, and what moves the valve."""
        shown_by = {"measured": {Channel.SPOOL_POSITION}, "command": {Channel.INPUT_VOLTAGE}}
        supply = {Channel.SUPPLY_PRESSURE} if self.supply == "measured" else set()
        motion = {Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION}
        return frozenset(motion | shown_by.get(self.spool, set()) | supply)

    @property
    def optional_channels(self) -> frozenset[Channel]:
        """The supply pressure, if `supply` allows it to be used."""
        return frozenset({Channel.SUPPLY_PRESSURE} if self.supply == "auto" else set())

    def spool_position(self, records: RecordBatch) -> Array:
        """x_v [m], shape (n_record, n_time); a command is held between samples (zero-order hold).

        The spool is initially at rest under the first command.
        """
        from scipy.signal import lfilter

        if self.spool == "measured":
            return np.ascontiguousarray(records[Channel.SPOOL_POSITION])
        command = records[Channel.INPUT_VOLTAGE]
        numerator, denominator, at_rest = _held_command_filter(
            self.natural_frequency, self.damping_ratio, records.sampling_frequency
        )
        position, _ = lfilter(numerator, denominator, command, zi=at_rest * command[:, :1])
        return np.ascontiguousarray(self.spool_gain * np.asarray(position))

    def supply_over_time(
        self, records: RecordBatch, total: Array, unclear: NDArray[np.bool_], every: int, least_gain: float
    ) -> Array:
        """P_s [Pa]; if it is the ``sum``, `follow_means` of the `total` (n_record, n_time)."""
        from hydrofdi.indicators.estimation.valve_use import follow_means

        match self.supply_known_by(records):
            case "measured":
                return np.ascontiguousarray(records[Channel.SUPPLY_PRESSURE])
            case "nominal":
                return np.full(total.shape, self.supply_pressure)
        supply = np.empty(total.shape)
        follow_means(np.ascontiguousarray(total), unclear, every, least_gain, self.supply_pressure, supply)
        return supply

    def supply_known_by(self, records: RecordBatch) -> Literal["measured", "nominal", "sum"]:
        """Resolve ``supply: auto`` for these records."""
        if self.supply != "auto":
            return self.supply
        if Channel.SUPPLY_PRESSURE in records.channels.keys() - records.relative:
            return "measured"
        return "sum" if self.areas[0] == self.areas[1] else "nominal"


@lru_cache(maxsize=64)
def _held_command_filter(
    natural_frequency: float, damping_ratio: float, sampling_frequency: float
) -> tuple[Array, Array, Array]:
    """Numerator and denominator of a second-order lag with zero-order hold, and its steady state."""
    from scipy.signal import cont2discrete, lfilter_zi

    rate = 2.0 * np.pi * natural_frequency
    continuous = np.array([rate**2]), np.array([1.0, 2.0 * damping_ratio * rate, rate**2])
    numerator, denominator, _ = cont2discrete(continuous, 1.0 / sampling_frequency)
    return numerator[0], denominator, lfilter_zi(numerator[0], denominator)


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
        from hydrofdi.physics.valve import clearance_conductance

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
