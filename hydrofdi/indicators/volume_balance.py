"""The volume balance of the chambers, linear in what is not known of the actuator.

Signals have the shape (n_record, n_time); q_1 flows into chamber 1, q_2 out of chamber 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.physics.signed_root import signed_root
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.transforms.weak_form import Kind, weak_integrals

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION

_LEAST_ROOT = 300.0
"""Root of the drop over an edge below which its slope is not trusted [√Pa]: 0.09 MPa."""


@dataclass(frozen=True)
class VolumeBalance:
    """Equations of the chambers of records, integrated over windows.

    Attributes
    ----------
    records : RecordBatch
    actuator : NominalActuator
    both_pressures : bool
        Whether P_2 is measured; else it is P_s + P_r − P_1, and the balance of chamber 1 stands alone.
    by_spring : bool
        Whether the position is what the spring has under the difference of pressures.
    half : int
        Half of a window [samples].
    """

    records: RecordBatch
    actuator: NominalActuator
    both_pressures: bool
    by_spring: bool
    half: int

    @cached_property
    def spool(self) -> Array:
        """Spool position x_v [m]."""
        return self.actuator.spool_position(self.records)

    @cached_property
    def supply(self) -> Array:
        """P_s [Pa], shape (n_record, n_time) or (n_record, 1)."""
        records, actuator = self.records, self.actuator
        match actuator.supply_known_by(records):
            case "measured":
                return records[Channel.SUPPLY_PRESSURE]
            case "nominal":
                return np.full((records.n_record, 1), actuator.supply_pressure)
        if self.both_pressures:
            total = np.median(records[P1] + records[P2], axis=1, keepdims=True)
        else:
            total = 2.0 * np.mean(records[P1], axis=1, keepdims=True)
            if not self.by_spring:
                stiffness = actuator.load_stiffness / actuator.areas[0]
                total = total - stiffness * np.mean(records[X], axis=1, keepdims=True)
        return np.asarray(total - actuator.return_pressure)

    @cached_property
    def pressures(self) -> tuple[Array, Array]:
        """P_1 and P_2 [Pa]."""
        first = self.records[P1]
        if self.both_pressures:
            return first, self.records[P2]
        return first, self.supply + self.actuator.return_pressure - first

    @cached_property
    def position(self) -> Array:
        """x_p [m]."""
        if not self.by_spring:
            return self.records[X]
        (area_1, area_2), (first, second) = self.actuator.areas, self.pressures
        return (area_1 * first - area_2 * second) / self.actuator.load_stiffness

    def equations(self) -> Iterator[tuple[dict[str, Array], Array]]:
        """Unknown → its column, and the target [m³], each (n_record, n_window), of each chamber."""
        frequency, half = self.records.sampling_frequency, self.half
        place, travel = self._integrals(self.position, "value", "rate")
        place, speed = place * frequency / half, travel * frequency / half
        (leak,) = self._integrals(signed_root(self.pressures[0] - self.pressures[1]), "value")
        for chamber in (0, 1) if self.both_pressures else (0,):
            sign = 1.0 if chamber == 0 else -1.0
            area, volume = self.actuator.areas[chamber], self.actuator.volumes[chamber]
            rise, late_rise = self._integrals(self.pressures[chamber], "rate", "late_rate")
            compressed = sign * (volume + sign * area * place) * rise + area * speed * late_rise
            flow, columns = self._valve(chamber)
            columns |= {"internal_coefficient": leak, "compressibility": compressed}
            yield columns, flow - area * travel - compressed / self.actuator.bulk_modulus

    def _valve(self, chamber: int) -> tuple[Array, dict[str, Array]]:
        """Nominal flow through the valve [m³], and the columns of the unknowns of valve and sensors."""
        actuator, spool, supply = self.actuator, self.spool, self.supply
        ret, pressure = actuator.return_pressure, self.pressures[chamber]
        drop = (chamber_1_orifice_drop, chamber_2_orifice_drop)[chamber](spool, pressure, supply, ret)
        root = signed_root(drop)
        gain = actuator.flow_gain * actuator.area_gradient
        opened = gain * root
        flow = opened * spool
        slope = 0.5 * gain * spool / np.maximum(np.abs(root), _LEAST_ROOT)
        fed = slope * ((spool >= 0.0) == (chamber == 0))
        centre = supply + ret - 2.0 * pressure
        signals = (flow, fed * supply, opened, opened * np.sign(spool), centre, fed, slope - fed)
        flow, by_supply, by_offset, by_lap, by_clearance, by_fed, by_drained = (
            self._integrals(signal, "value")[0] for signal in signals
        )
        columns = {
            "flow_gain": -flow,
            "supply": -by_supply,
            "offset": by_offset,
            "lap": by_lap,
            "clearance": -by_clearance if chamber == 0 else by_clearance,
        }
        return flow, columns | self._biases(chamber, by_fed, by_drained)

    def _biases(self, chamber: int, fed: Array, drained: Array) -> dict[str, Array]:
        """Pressures that are shown too high; those that give the supply pressure move it as well."""
        gives_supply = self.actuator.supply_known_by(self.records) == "sum"
        if not self.both_pressures:
            return {"bias_1": drained + fed if gives_supply else drained - fed}
        own, other = (drained, fed) if gives_supply else (drained - fed, np.zeros_like(fed))
        return {"bias_1": own, "bias_2": other} if chamber == 0 else {"bias_1": other, "bias_2": own}

    def _integrals(self, signal: Array, *kinds: Kind) -> Array:
        return weak_integrals(signal, self.records.sampling_frequency, self.half, *kinds)
