"""No-load flow and speed: upper bounds of flows and piston speeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.physics.valve import control_flow
from hydrofdi.simulation.drive import largest_voltage
from hydrofdi.simulation.trajectory import Trajectory


def no_load_flow(parameters: RunParameters, opening: float | None = None) -> float:
    """Control flow at equal chamber pressures and a given opening [m], by default the largest [m³/s]."""
    valve, supply = parameters.valve, parameters.supply
    gain = max(edge.flow_gain for edge in parameters.edges)
    drop = 0.5 * (supply.pressure - supply.return_pressure)
    most = largest_opening(parameters) if opening is None else opening
    return float(control_flow(most, drop, gain, valve.area_gradient))


def largest_leakage_flows(runs: Sequence[RunParameters], trajectory: Trajectory) -> NDArray[np.float64]:
    """Upper bound of the mean leakage flow of a record, shape (n_run,) [m³/s].

    By continuity, it is the no-load flow at the mean opening plus the flow displaced by the piston.
    """
    openings = np.mean(np.abs(trajectory.spool_position), axis=1)
    speeds = np.mean(np.abs(trajectory.piston_velocity), axis=1)
    return np.array([
        no_load_flow(run, opening + run.valve.largest_null(run.record.duration) + run.edges.largest_underlap)
        + run.actuator.piston_area * speed
        for run, opening, speed in zip(runs, openings, speeds, strict=True)
    ])  # fmt: skip


def no_load_speed(parameters: RunParameters) -> float:
    """No-load speed of the piston [m/s]."""
    return no_load_flow(parameters) / parameters.actuator.piston_area


def largest_opening(parameters: RunParameters) -> float:
    """Largest edge opening that input or controller can command [m]."""
    control, valve = parameters.control, parameters.valve
    voltage = control.voltage_limit
    if not control.is_closed:
        voltage = largest_voltage(parameters.input, parameters.record)
    travel = min(valve.spool_gain * voltage, valve.position_limit)
    return travel + valve.largest_null(parameters.record.duration) + parameters.edges.largest_underlap
