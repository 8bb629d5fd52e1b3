"""Nominal valve flows from the data sheet, and the order of the input signals of observers."""

from __future__ import annotations

from typing import NamedTuple

from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow

P1, P2, POSITION, SPOOL, SUPPLY = range(5)
"""Signals of an observer: pressures [Pa], positions of piston and spool [m], and supply pressure [Pa]."""

N_SIGNAL = 5


class Cylinder(NamedTuple):
    """Nominal actuator, in SI.

    Attributes
    ----------
    area_1, area_2 : float
        [m²]
    volume_1, volume_2 : float
        Volume at position zero [m³].
    flow_gain : float
        K_v [m^1.5/kg^0.5].
    area_gradient : float
        w [m].
    ret : float
        Return pressure [Pa].
    """

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
