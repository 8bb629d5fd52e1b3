"""Input signals of observers: measured if available, else computed with the nominal valve."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydrofdi.indicators.estimation.valve_use import mark_unclear
from hydrofdi.indicators.nominal_actuator import NominalActuator
from hydrofdi.indicators.recursive import RecursiveOptions
from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow
from hydrofdi.records import Array, Channel, RecordBatch
from hydrofdi.settings.quantities import SI

P1, P2, POSITION, SPOOL, SUPPLY = range(5)
"""Signals of an observer: pressures [Pa], positions of piston and spool [m], and supply pressure [Pa]."""

N_SIGNAL = 5


@equation
def signals_at(signals: Array, row: int, k: int) -> tuple[float, float, float, float, float]:
    """Signals of a sample, in order."""
    one = signals[:, row, k]
    return one[P1], one[P2], one[POSITION], one[SPOOL], one[SUPPLY]


class Cylinder(NamedTuple):
    """Nominal actuator, in SI; volumes at position zero, K_v and w, and the return pressure."""

    area_1: float
    area_2: float
    volume_1: float
    volume_2: float
    flow_gain: float
    area_gradient: float
    ret: float


@equation
def nominal_flows(
    spool: Quantity, pressure_1: Quantity, pressure_2: Quantity, supply: Quantity, cylinder: Cylinder
) -> tuple[Quantity, Quantity]:
    """q_1 into chamber 1 and q_2 out of chamber 2 [m³/s]; all in SI."""
    ret, gain, gradient = cylinder.ret, cylinder.flow_gain, cylinder.area_gradient
    drop_1 = chamber_1_orifice_drop(spool, pressure_1, supply, ret)
    drop_2 = chamber_2_orifice_drop(spool, pressure_2, supply, ret)
    return control_flow(spool, drop_1, gain, gradient), control_flow(spool, drop_2, gain, gradient)


_BLOCK = 16
"""Number of consecutive samples of P_1 + P_2 that are averaged, if the valve is open at all of them."""


class ObserverOptions(NominalActuator, RecursiveOptions):
    """Options of observers of the chamber pressures."""

    supply_memory: Annotated[float, SI("s", above=0)] = 5.0
    """Time constant of the mean of P_1 + P_2, for ``supply: sum`` [s]."""

    least_opening: Annotated[float, SI("m", least=0)] = 5e-6
    """No adaptation while the spool is closer to its centre than this [m]: there the flow depends on lap and
    offset."""

    reference_pressure: Annotated[float, SI("Pa", least=1e4, most=2e8)] = 8e6
    """Pressure difference at which leakage flows are stated [Pa]."""

    @property
    def cylinder(self) -> Cylinder:
        """Parameters of the cylinder for kernels."""
        return Cylinder(*self.areas, *self.volumes, self.flow_gain, self.area_gradient, self.return_pressure)

    def observed(self, records: RecordBatch) -> tuple[Array, NDArray[np.bool_]]:
        """Signals (5, n_record, n_time) in SI, and samples without information (n_record, n_time).

        The order is that of the indices above.
        """
        shape = records.n_record, records.n_time
        signals, unclear = np.empty((N_SIGNAL, *shape)), np.zeros(shape, dtype=np.bool_)
        signals[P1], signals[P2] = records[Channel.CHAMBER_1_PRESSURE], records[Channel.CHAMBER_2_PRESSURE]
        signals[POSITION] = self.position(records)
        signals[SPOOL] = self.spool_position(records)
        mark_unclear(signals[SPOOL], 0, self.least_opening, math.inf, 0, unclear)
        total = signals[P1] + signals[P2] - self.return_pressure
        gain = -math.expm1(-_BLOCK / records.sampling_frequency / self.supply_memory)
        signals[SUPPLY] = self.supply_over_time(records, total, unclear, _BLOCK, gain)
        return signals, unclear
