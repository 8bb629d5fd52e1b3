"""The right-hand side: the rates of a run's four hydraulic states, put together from the equations."""

from __future__ import annotations

from typing import Any, NamedTuple

from hydrofdi.physics.cylinder import chamber_pressure_rates, piston_acceleration
from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.friction import friction_force, smooth_friction_force
from hydrofdi.physics.leakage import (
    blended_leakage_flow,
    external_leakage_flow,
    intermittent_onset,
    internal_leakage_flow,
    laminar_leakage_flow,
    onset_ramp,
)
from hydrofdi.physics.valve import chamber_1_orifice_drop, chamber_2_orifice_drop, control_flow
from hydrofdi.simulation.options import ModelOptions

State = tuple[float, float, float, float]
"""x_p [m], v_p [m/s], P_1 and P_2 [Pa]."""


class LaneParameters(NamedTuple):
    """The parameters of one run, in SI; the fields of ``lanes.PARAMETERS``."""

    mass: float
    area: float
    volume: float
    stiffness: float
    supply: float
    ret: float
    bulk_modulus: float
    flow_gain: float
    area_gradient: float
    coulomb: float
    breakaway: float
    viscous: float
    transition: float
    velocity_threshold: float
    internal_leakage: float
    external_leakage_1: float
    external_leakage_2: float
    laminar_reference: float
    blending_pressure: float
    onset_time: float
    onset_duration: float
    onset_duty: float


@equation
def row_parameters(row: Any, time: Quantity, options: ModelOptions) -> LaneParameters:
    """A row of `parameter_matrix` with names, at an instant."""
    return LaneParameters(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7],
        row[8], row[9], row[10], row[11], row[12], row[13],
        open_leakage(time, row[14], row[19], row[20], row[21], options),
        row[15], row[16], row[17], row[18], row[19], row[20], row[21],
    )  # fmt: skip


class PortFlows(NamedTuple):
    """Flows [m³/s]: q_1 and q_2 through the valve, q_il across the piston, q_el1 and q_el2 to the outside."""

    control_1: float
    control_2: float
    internal: float
    external_1: float
    external_2: float


@equation
def open_leakage(
    time: Quantity,
    coefficient: Quantity,
    start: Quantity,
    duration: Quantity,
    duty: Quantity,
    options: ModelOptions,
) -> Quantity:
    """K_i at an instant [m^3.5/kg^0.5]; it is held over a step."""
    if options.ramped_leakage is not None:
        return coefficient * onset_ramp(time, start, duration)
    if options.intermittent_leakage is not None:
        return coefficient * intermittent_onset(time, start, duration, duty)
    return coefficient


@equation
def leakage_of(pressure_difference: Quantity, p: LaneParameters, options: ModelOptions) -> Quantity:
    """Internal leakage flow [m³/s] by the law that was chosen."""
    if options.laminar_leakage is not None:
        return laminar_leakage_flow(pressure_difference, p.internal_leakage, p.laminar_reference)
    if options.blended_leakage is not None:
        return blended_leakage_flow(pressure_difference, p.internal_leakage, p.blending_pressure)
    return internal_leakage_flow(pressure_difference, p.internal_leakage)


@equation
def port_flows(
    pressure_1: float, pressure_2: float, spool_position: float, p: LaneParameters, options: ModelOptions
) -> PortFlows:
    """All flows into and out of the chambers."""
    drop_1 = chamber_1_orifice_drop(spool_position, pressure_1, p.supply, p.ret)
    drop_2 = chamber_2_orifice_drop(spool_position, pressure_2, p.supply, p.ret)
    return PortFlows(
        control_flow(spool_position, drop_1, p.flow_gain, p.area_gradient),
        control_flow(spool_position, drop_2, p.flow_gain, p.area_gradient),
        leakage_of(pressure_1 - pressure_2, p, options),
        external_leakage_flow(pressure_1, p.external_leakage_1),
        external_leakage_flow(pressure_2, p.external_leakage_2),
    )


@equation
def friction_of(velocity: float, p: LaneParameters, options: ModelOptions) -> float:
    """Friction force [N] by the law that was chosen."""
    if options.smooth_friction is not None:
        return smooth_friction_force(
            velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold
        )
    return friction_force(velocity, p.coulomb, p.breakaway, p.viscous, p.transition, p.velocity_threshold)


@equation
def hydraulic_rates(state: State, spool_position: float, p: LaneParameters, options: ModelOptions) -> State:
    """Time derivatives of the state."""
    x, v, p1, p2 = state
    friction = friction_of(v, p, options)
    flows = port_flows(p1, p2, spool_position, p, options)
    net_1 = flows.control_1 - flows.internal - flows.external_1 - p.area * v
    net_2 = flows.internal - flows.control_2 - flows.external_2 + p.area * v
    rate_1, rate_2 = chamber_pressure_rates(x, net_1, net_2, p.bulk_modulus, p.volume, p.area)
    return v, piston_acceleration(x, p1, p2, friction, p.mass, p.area, p.stiffness), rate_1, rate_2
