"""The hydraulic mode at the working point of a record."""

from __future__ import annotations

import math

import numpy as np

from hydrofdi.config import RunParameters
from hydrofdi.config.leakage import LeakageConfig
from hydrofdi.physics.hydraulic_mode import (
    HydraulicMode,
    blended_conductance,
    laminar_conductance,
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    valve_flow_pressure_coefficient,
)
from hydrofdi.physics.valve import chamber_1_orifice_drop
from hydrofdi.simulation import Trajectory


def hydraulic_mode(parameters: RunParameters, trajectory: Trajectory, run: int = 0) -> HydraulicMode:
    """Frequency and damping of the hydraulic mode at the median working point of a record.

    Valve opening, orifice drop and pressure difference are the medians of their absolute values over the
    samples; K_c and G are singular where a drop vanishes, so a mean would be ruled by single samples.

    Parameters
    ----------
    parameters : RunParameters
    trajectory : Trajectory
    run : int
        Row of the trajectory.

    Returns
    -------
    HydraulicMode
        Frequency [Hz], piston centred, and damping ratio [-]; the ratio is infinite where the median drop
        or, with a leak, the median pressure difference vanishes.
    """
    actuator, valve, supply = parameters.actuator, parameters.valve, parameters.supply
    beta, mass = np.float64(parameters.fluid.bulk_modulus), np.float64(actuator.mass)
    spool, pressure_1 = trajectory.spool_position[run], trajectory.chamber_1_pressure[run]
    drop = chamber_1_orifice_drop(spool, pressure_1, supply.pressure, supply.return_pressure)
    difference = pressure_1 - trajectory.chamber_2_pressure[run]
    coefficient = trajectory.leakage_coefficient[run]
    with np.errstate(all="ignore"):
        omega = mode_frequency(
            beta, np.float64(actuator.piston_area), actuator.chamber_volume, mass, actuator.load_stiffness
        )
        damping = mode_damping_ratio(
            omega, beta, actuator.chamber_volume, mass, parameters.friction.viscous,
            valve_flow_pressure_coefficient(
                _median_size(spool), _median_size(drop), valve.flow_gain, valve.area_gradient
            ),
            _conductance(parameters.leakage, _median_size(difference), coefficient),
        )  # fmt: skip
    return HydraulicMode(float(omega / (2.0 * math.pi)), float(damping))


def _conductance(leakage: LeakageConfig, difference: float, coefficient: float) -> float:
    if not coefficient:
        return 0.0
    if leakage.law == "laminar":
        return laminar_conductance(coefficient, leakage.laminar_reference)
    if leakage.law == "blended":
        return blended_conductance(difference, coefficient, leakage.blending_pressure)
    return leakage_conductance(difference, coefficient)


def _median_size(signal: object) -> np.float64:
    return np.float64(np.median(np.abs(np.asarray(signal)), overwrite_input=True))
