"""Volume balance of the chambers, linear in the unknown parameters of the actuator.

Signals have the shape (n_record, n_time); q_1 flows into chamber 1, q_2 out of chamber 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hydrofdi.indicators.estimation.chamber_balance import Balance, new_sums, weak_weights, window_equations
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.records import Array, Channel, RecordBatch

P1, P2, X = Channel.CHAMBER_1_PRESSURE, Channel.CHAMBER_2_PRESSURE, Channel.PISTON_POSITION


@dataclass(frozen=True)
class VolumeBalance:
    """Volume balance equations of the chambers, integrated over windows.

    Attributes
    ----------
    records : RecordBatch
    actuator : NominalActuator
    both_pressures : bool
        Whether P_2 is measured; else P_2 = P_s + P_r − P_1, and only the balance of chamber 1 is used.
    by_spring : bool
        Whether the position is computed from the pressure difference and the load spring.
    half : int
        Half the window length [samples].
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
                total = total - stiffness * np.mean(actuator.position(records), axis=1, keepdims=True)
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
            return self.actuator.position(self.records)
        (area_1, area_2), (first, second) = self.actuator.areas, self.pressures
        return (area_1 * first - area_2 * second) / self.actuator.load_stiffness

    def equations(self) -> tuple[Array, Array]:
        """Regressors (n_record, n_window, n_chamber, N_UNKNOWN) and targets [m³] of all windows."""
        records, supply = self.records, _whole(self.supply, self.records)
        return window_equations(
            _whole(self.spool, records), _whole(self.position, records),
            np.stack([_whole(pressure, records) for pressure in self.pressures]), supply, supply,
            weak_weights(self.half, records.sampling_frequency), 0,
            known_balance(self.actuator, records, self.both_pressures, self.half),
            new_sums(records.n_record, 2 if self.both_pressures else 1),
        )  # fmt: skip


def known_balance(
    actuator: NominalActuator, records: RecordBatch, both_pressures: bool, half: int
) -> Balance:
    """Known parameters of the equations.

    Errors of pressures that determine the supply pressure are included.
    """
    own_feed, other_feed = -1.0, 0.0
    if actuator.supply_known_by(records) == "sum":
        own_feed, other_feed = (0.0, 1.0) if both_pressures else (1.0, 0.0)
    return Balance(
        *actuator.areas, *actuator.volumes, actuator.flow_gain * actuator.area_gradient,
        actuator.return_pressure, 1.0 / actuator.bulk_modulus, own_feed, other_feed,
        half / records.sampling_frequency,
    )  # fmt: skip


def _whole(signal: Array, records: RecordBatch) -> Array:
    return np.ascontiguousarray(np.broadcast_to(signal, (records.n_record, records.n_time)))
