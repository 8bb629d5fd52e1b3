"""The fastest that a valve can move the piston: the bound of flows and speeds."""

from __future__ import annotations

from hydrofdi.config import RunParameters
from hydrofdi.physics.valve import control_flow
from hydrofdi.simulation.drive import largest_voltage


def no_load_flow(parameters: RunParameters) -> float:
    """Control flow at the largest opening and equal chamber pressures [m³/s]."""
    valve, supply = parameters.valve, parameters.supply
    drop = 0.5 * (supply.pressure - supply.return_pressure)
    return float(control_flow(_largest_opening(parameters), drop, valve.flow_gain, valve.area_gradient))


def no_load_speed(parameters: RunParameters) -> float:
    """Speed of the piston at that flow [m/s]."""
    return no_load_flow(parameters) / parameters.actuator.piston_area


def _largest_opening(parameters: RunParameters) -> float:
    """Largest opening of an edge that input or controller can ask for [m]."""
    control, valve = parameters.control, parameters.valve
    voltage = control.voltage_limit
    if not control.is_closed:
        voltage = largest_voltage(parameters.input, parameters.run)
    return min(valve.spool_gain * voltage, valve.position_limit) + max(-valve.lap, 0.0)
