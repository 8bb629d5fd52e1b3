"""The hydraulic mode at the working point of a record."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import RunParameters
from hydrofdi.config.sections.fluid import FluidConfig
from hydrofdi.config.sections.leakage import LeakageConfig
from hydrofdi.physics.fluid import effective_bulk_modulus
from hydrofdi.physics.hydraulic_mode import (
    HydraulicMode,
    blended_conductance,
    laminar_conductance,
    leakage_conductance,
    mode_damping_ratio,
    mode_frequency,
    valve_flow_pressure_coefficient,
)
from hydrofdi.physics.valve import chamber_1_orifice_drop, null_position
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
        Frequency [Hz], piston centred, and damping ratio [-]; the ratio is infinite if the median drop
        or, with a leak, the median pressure difference vanishes.
    """
    actuator = parameters.actuator
    mass = np.float64(actuator.mass)
    pressure_1, pressure_2 = trajectory.chamber_1_pressure[run], trajectory.chamber_2_pressure[run]
    coefficient = trajectory.leakage_coefficient[run]
    with np.errstate(all="ignore"):
        beta = _modulus(parameters.fluid, pressure_1, pressure_2)
        omega = mode_frequency(
            beta, np.float64(actuator.piston_area), actuator.chamber_volume, mass, actuator.load_stiffness
        )
        damping = mode_damping_ratio(
            omega, beta, actuator.chamber_volume, mass, parameters.friction.viscous,
            _valve_coefficient(parameters, trajectory, run),
            _conductance(parameters.leakage, _median_size(pressure_1 - pressure_2), coefficient),
        )  # fmt: skip
    return HydraulicMode(float(omega / (2.0 * math.pi)), float(damping))


def _modulus(fluid: FluidConfig, *pressures: NDArray[np.float64]) -> np.float64:
    """β [Pa]; with free air the mean of those at the median pressures of the chambers."""
    if fluid.law == "constant":
        return np.float64(fluid.bulk_modulus)
    moduli = [
        effective_bulk_modulus(
            np.median(pressure), fluid.bulk_modulus, fluid.free_air, fluid.polytropic_exponent,
            fluid.atmospheric_pressure,
        )
        for pressure in pressures
    ]  # fmt: skip
    return np.float64(np.mean(moduli))


def _valve_coefficient(parameters: RunParameters, trajectory: Trajectory, run: int) -> float:
    """K_c of the edge that feeds chamber 1, mean clearances and mean K_e of the chambers [m³/(s·Pa)]."""
    valve = parameters.valve
    null = null_position(trajectory.time, valve.null_offset, valve.null_drift)
    spool = trajectory.spool_position[run] - null
    drop = chamber_1_orifice_drop(
        spool, trajectory.chamber_1_pressure[run], trajectory.valve_supply_pressure[run],
        parameters.supply.return_pressure,
    )  # fmt: skip
    edges = parameters.edges
    feeding = edges.supply_1
    opening = np.maximum(_median_size(spool) - feeding.lap, 0.0) if feeding.lap else _median_size(spool)
    leakage = parameters.leakage
    external = 0.5 * (leakage.chamber_1_coefficient + leakage.chamber_2_coefficient)
    edge = valve_flow_pressure_coefficient(
        opening, _median_size(drop), feeding.flow_gain, valve.area_gradient
    )
    return edge + 0.5 * sum(edges.clearances) + external


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
