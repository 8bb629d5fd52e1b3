"""Right-hand side: rates of the hydraulic states of a run."""

from __future__ import annotations

from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrofdi.physics import Quantity
from hydrofdi.physics.cylinder import (
    blended_leakage_flow,
    chamber_pressure_rates,
    dragged_pressure_difference,
    end_stop_force,
    external_leakage_flow,
    foundation_velocity,
    internal_leakage_flow,
    laminar_leakage_flow,
    line_flow_rate,
    line_pressure_rate,
    onset_ramp,
    piston_acceleration,
    pressure_force,
    scored_share,
)
from hydrofdi.physics.fluid import effective_bulk_modulus, stiffening_bulk_modulus, temperature_factor
from hydrofdi.physics.friction import FRICTION_LAWS, dry_friction_factor
from hydrofdi.physics.valve import (
    chamber_1_orifice_drop,
    chamber_2_orifice_drop,
    control_flow,
    edge_flow,
    null_position,
    return_pressure_rate,
    ripple_rate,
    supply_pressure_rate,
    worn_opening,
)
from hydrofdi.simulation.lanes import LEAKAGE, PARAMETERS, ModelOptions


class State(NamedTuple):
    """x_p [m], v_p [m/s], P_1, P_2, P_s [Pa], z [m], P_r [Pa], x_b [m], and of both hoses the pressure at the
    valve [Pa] and the flow into chamber 1 or out of chamber 2 [m³/s]; from P_s on constant without options.
    """

    position: float
    velocity: float
    pressure_1: float
    pressure_2: float
    supply: float
    bristle: float
    return_pressure: float
    support: float
    line_pressure_1: float
    line_flow_1: float
    line_pressure_2: float
    line_flow_2: float


if TYPE_CHECKING:
    LaneParameters = Any
else:
    LaneParameters = namedtuple("LaneParameters", (*PARAMETERS, LEAKAGE))
    """Parameters of one run at an instant, in SI: the lane fields of the same names."""

_DRY = ("coulomb", "breakaway")
_WARMED = {
    "bulk_modulus": ("bulk_modulus_slope", 1.0),  # (5c)
    # Laminar flow is inversely proportional to viscosity; the drag, matched by its name, is set right below.
    **{name: ("viscosity_slope", -1.0) for name in PARAMETERS if "leakage" in name},
    **dict.fromkeys(("viscous", "leakage_drag"), ("viscosity_slope", 1.0)),
}
"""Lane field → field of its relative change per temperature [1/K], and sign."""


def lane_parameters(
    lanes: Any, k: Any, time: Quantity, middle: Quantity, options: ModelOptions
) -> LaneParameters:
    """Parameters of a lane at an instant.

    Parameters
    ----------
    lanes : record
        Fields of `lanes.PARAMETERS` and K_i, each with an axis of lanes.
    k : int or ...
        Lane.
    time, middle : float or array
        Start and middle of a step [s].
    """

    def of_lane(name: str) -> Quantity:
        return getattr(lanes, name)[k]

    def warmed(name: str, slope: str, sign: float) -> Quantity:
        rise, drift = of_lane("temperature_rise"), of_lane("temperature_drift")
        return of_lane(name) * temperature_factor(time, rise, drift, sign * of_lane(slope))

    values = {name: of_lane(name) for name in (*PARAMETERS, LEAKAGE)}
    if options.warm_oil:
        values |= {name: warmed(name, *change) for name, change in _WARMED.items()}
        # An orifice does not depend on viscosity.
        if options.laminar_leakage:
            values[LEAKAGE] = warmed(LEAKAGE, "viscosity_slope", -1.0)
    if options.shifted_null:
        values["null_offset"] = null_position(time, values["null_offset"], values["null_drift"])  # (7c)
    if options.supply_ripple:
        # (7e): with its rate at the middle, a step is accurate to second order in the ripple.
        values["ripple"] = ripple_rate(middle, values["ripple"], values["ripple_frequency"])
    if options.ramped_leakage:
        share = onset_ramp(time, values["onset_time"], values["onset_duration"])  # (11c)
        values[LEAKAGE] = values[LEAKAGE] * share
    return LaneParameters(**values)


class ValveFlows(NamedTuple):
    """Flows across the edges of the valve.

    Attributes
    ----------
    control_1, control_2, supply, returned : float
        q_1 into chamber 1, q_2 out of chamber 2, q_s from the supply and q_r to the return [m³/s].
    throttling : float
        Power dissipated at the edges [W].
    """

    control_1: float
    control_2: float
    supply: float
    returned: float
    throttling: float


class PortFlows(NamedTuple):
    """Flows into and out of the chambers.

    Attributes
    ----------
    into_1, from_2 : float
        Flow through the port into chamber 1, and out of chamber 2 [m³/s].
    internal, external_1, external_2 : float
        q_il across the piston, q_el1 and q_el2 to the outside [m³/s].
    """

    valve: ValveFlows
    into_1: float
    from_2: float
    internal: float
    external_1: float
    external_2: float


def chamber_2(p: LaneParameters, options: ModelOptions) -> tuple[float, float]:
    """Area [m²] and volume with the piston centred [m³] of chamber 2."""
    if not options.unequal_chambers:
        return p.area, p.volume
    return p.area_2, p.volume_2


def force_of_pressures(state: State, p: LaneParameters, options: ModelOptions) -> float:
    """Force of the chamber pressures on the piston [N]."""
    # A (P_1 − P_2) and A P_1 − A P_2 round differently, and equal areas keep their bits.
    if not options.unequal_chambers:
        return p.area * (state.pressure_1 - state.pressure_2)  # type: ignore[no-any-return]
    return pressure_force(state.pressure_1, state.pressure_2, p.area, p.area_2)  # type: ignore[no-any-return]


def position_in_cylinder(state: State, options: ModelOptions) -> float:
    """Position of the piston relative to the cylinder [m]."""
    return state.position - state.support if options.foundation else state.position  # (2b)


def friction_of(state: State, p: LaneParameters, options: ModelOptions) -> tuple[float, float]:
    """Friction force [N] and bristle rate [m/s] by the chosen law."""
    if options.uneven_friction:
        difference, position = state.pressure_1 - state.pressure_2, position_in_cylinder(state, options)
        factor = dry_friction_factor(  # (12c)
            difference, position, p.pressure_slope, p.position_share, p.position_period
        )
        p = p._replace(**{name: getattr(p, name) * factor for name in _DRY})
    return FRICTION_LAWS[options.friction_law].friction(state.velocity, state.bristle, p)


def leakage_of(
    pressure_difference: Quantity,
    position: Quantity,
    velocity: Quantity,
    p: LaneParameters,
    options: ModelOptions,
) -> Quantity:
    """Internal leakage flow by the chosen law [m³/s]."""
    coefficient = p.internal_leakage
    if options.dragged_leakage:
        # (11e): motion towards chamber 2 adds to P_1 − P_2.
        pressure_difference = dragged_pressure_difference(pressure_difference, velocity, p.leakage_drag)
    if options.scored_bore:
        coefficient = coefficient * scored_share(position, p.scored_centre, p.scored_width)  # (11f)
    if options.laminar_leakage:
        return laminar_leakage_flow(pressure_difference, coefficient, p.laminar_reference)  # (11a)
    if options.blended_leakage:
        return blended_leakage_flow(pressure_difference, coefficient, p.blending_pressure)  # (11b)
    return internal_leakage_flow(pressure_difference, coefficient)  # (11)


def valve_flows(state: State, spool_position: float, p: LaneParameters, options: ModelOptions) -> ValveFlows:
    """Flows across the edges of the valve.

    With critical lap, only two of the four edges are open at a time, so two orifices suffice.
    """
    ret = state.return_pressure if options.return_line else p.ret
    # (5d): with hoses, the edges see the pressures at the valve, not those of the chambers.
    port_1 = state.line_pressure_1 if options.hoses else state.pressure_1
    port_2 = state.line_pressure_2 if options.hoses else state.pressure_2
    if options.shifted_null:
        spool_position = spool_position - p.null_offset
    if options.lapped_valve:
        to_1, from_1 = state.supply - port_1, port_1 - ret
        to_2, from_2 = state.supply - port_2, port_2 - ret
        # (7a): x opens the supply edge of chamber 1 and the return edge of chamber 2, −x the other two.
        x, y = spool_position, -spool_position
        feed_1 = _edge(x, to_1, p.supply_1_lap, p.supply_1_leakage, p.supply_1_gain, p, options)
        drain_1 = _edge(y, from_1, p.return_1_lap, p.return_1_leakage, p.return_1_gain, p, options)
        feed_2 = _edge(y, to_2, p.supply_2_lap, p.supply_2_leakage, p.supply_2_gain, p, options)
        drain_2 = _edge(x, from_2, p.return_2_lap, p.return_2_leakage, p.return_2_gain, p, options)
        # Flow and drop of an edge have the same sign, so each term is positive.
        throttling = to_1 * feed_1 + from_1 * drain_1 + to_2 * feed_2 + from_2 * drain_2
        # Positive flows go into chamber 1 and out of chamber 2.
        return ValveFlows(feed_1 - drain_1, drain_2 - feed_2, feed_1 + feed_2, drain_1 + drain_2, throttling)
    drop_1 = chamber_1_orifice_drop(spool_position, port_1, state.supply, ret)
    drop_2 = chamber_2_orifice_drop(spool_position, port_2, state.supply, ret)
    flow_1 = control_flow(spool_position, drop_1, p.flow_gain, p.area_gradient)  # (7)
    flow_2 = control_flow(spool_position, drop_2, p.flow_gain, p.area_gradient)  # (8)
    # Here a flow also has the sign of x_v, which the power has not.
    throttling = abs(drop_1 * flow_1) + abs(drop_2 * flow_2)
    # At x_v < 0 the supply feeds chamber 2, whose flow counts outwards, hence the minus signs.
    opens_1 = spool_position >= 0.0
    supplied, returned = np.where(opens_1, flow_1, -flow_2), np.where(opens_1, flow_2, -flow_1)
    return ValveFlows(flow_1, flow_2, supplied, returned, throttling)


def _edge(
    spool_position: float,
    drop: float,
    lap: float,
    leakage: float,
    gain: float,
    p: LaneParameters,
    options: ModelOptions,
) -> float:
    # Those of an edge come on top of those of the valve; its gain is a ratio.
    lap, leakage, gain = p.lap + lap, p.lap_leakage + leakage, gain * p.flow_gain
    if options.worn_edges:
        opening = worn_opening(spool_position - lap, p.edge_rounding, p.gain_slope)
        # (7d) has already subtracted the lap.
        spool_position, lap = opening, 0.0
    flow: float = edge_flow(spool_position, drop, gain, p.area_gradient, lap, leakage)
    return flow


def port_flows(state: State, spool_position: float, p: LaneParameters, options: ModelOptions) -> PortFlows:
    """All flows into and out of the chambers."""
    valve = valve_flows(state, spool_position, p, options)
    into_1, from_2 = valve.control_1, valve.control_2
    if options.hoses:
        # (5d): the inertia of the hoses separates the flows into the chambers from those of the valve.
        into_1, from_2 = state.line_flow_1, state.line_flow_2
    position = position_in_cylinder(state, options)
    return PortFlows(
        valve,
        into_1,
        from_2,
        leakage_of(state.pressure_1 - state.pressure_2, position, state.velocity, p, options),
        external_leakage_flow(state.pressure_1, p.external_leakage_1),  # (9)
        external_leakage_flow(state.pressure_2, p.external_leakage_2),  # (10)
    )


def bulk_modulus_at(pressure: float, p: LaneParameters, options: ModelOptions) -> float:
    """β of the fluid in a chamber by the chosen law [Pa]."""
    modulus: float = p.bulk_modulus
    if options.stiffening:
        # (5e), which is β_l of (5a) if there is air as well.
        modulus = stiffening_bulk_modulus(pressure, modulus, p.pressure_stiffening)
    if options.free_air:
        modulus = effective_bulk_modulus(pressure, modulus, p.free_air, p.air_exponent, p.atmosphere)  # (5a)
    return modulus


def pressure_rates(
    state: State, net_1: float, net_2: float, p: LaneParameters, options: ModelOptions
) -> tuple[float, float]:
    """P_1' and P_2' from the net flows [m³/s] into the chambers [Pa/s]."""
    modulus = p.bulk_modulus
    if options.free_air or options.stiffening:
        # β differs between the chambers, so it goes into the flows; the common factor of (5) and (6) is 1.
        net_1 *= bulk_modulus_at(state.pressure_1, p, options)
        net_2 *= bulk_modulus_at(state.pressure_2, p, options)
        modulus = 1.0
    position = position_in_cylinder(state, options)
    area_2, volume_2 = chamber_2(p, options)
    rates: tuple[float, float] = chamber_pressure_rates(  # (5), (6)
        position, net_1, net_2, modulus, p.volume, volume_2, p.area, area_2
    )
    return rates


def hydraulic_rates(
    state: State, spool_position: float, load: float, p: LaneParameters, options: ModelOptions
) -> State:
    """Time derivatives of the state, at a spool position [m] and a load force [N]."""
    resistance, bristle = friction_of(state, p, options)
    # The cylinder feels friction and end stops; load and weight act on the piston alone.
    reaction = resistance
    if options.load_force:
        resistance += load
    if options.inclined:
        resistance += p.weight  # (2d)
    if options.end_stops:
        # (2a): the stops are part of the cylinder, and move with it.
        stopping = end_stop_force(position_in_cylinder(state, options), p.stop_position, p.stop_stiffness)
        resistance += stopping
        reaction += stopping
    support = support_velocity(state, reaction, p, options)
    flows = port_flows(state, spool_position, p, options)
    # (2b): the piston enlarges a chamber by its motion in the cylinder; friction depends on v_p itself.
    speed, area_2 = state.velocity - support, chamber_2(p, options)[0]
    # Net flows of (5) and (6) [m³/s]; internal leakage leaves chamber 1 and enters chamber 2.
    net_1 = flows.into_1 - flows.internal - flows.external_1 - p.area * speed
    net_2 = flows.internal - flows.from_2 - flows.external_2 + area_2 * speed
    rate_1, rate_2 = pressure_rates(state, net_1, net_2, p, options)
    force = force_of_pressures(state, p, options)
    acceleration = piston_acceleration(state.position, force, resistance, p.mass, p.stiffness)  # (2)
    supply, return_pressure = 0.0, 0.0
    if options.moving_supply:
        supply = supply_pressure_rate(  # (7b)
            state.supply, flows.valve.supply, p.rated_supply, p.droop_resistance, p.droop_time
        )
    if options.supply_ripple:
        supply += p.ripple  # (7e)
    if options.return_line:
        return_pressure = return_pressure_rate(  # (7f)
            state.return_pressure, flows.valve.returned, p.ret, p.return_resistance, p.return_time
        )
    line_1, line_2, flow_1, flow_2 = 0.0, 0.0, 0.0, 0.0
    if options.hoses:
        # (5d): flows count into chamber 1 and out of chamber 2, so the second hose has its ends exchanged.
        line_1 = line_pressure_rate(flows.valve.control_1 - flows.into_1, p.hose_modulus, p.hose_volume)
        line_2 = line_pressure_rate(flows.from_2 - flows.valve.control_2, p.hose_modulus, p.hose_volume)
        drop_1, drop_2 = state.line_pressure_1 - state.pressure_1, state.pressure_2 - state.line_pressure_2
        flow_1 = line_flow_rate(drop_1, state.line_flow_1, p.hose_resistance, p.hose_inertance)
        flow_2 = line_flow_rate(drop_2, state.line_flow_2, p.hose_resistance, p.hose_inertance)
    return State(
        state.velocity, acceleration, rate_1, rate_2, supply, bristle, return_pressure, support,
        line_1, flow_1, line_2, flow_2,
    )  # fmt: skip


def support_velocity(state: State, resistance: float, p: LaneParameters, options: ModelOptions) -> float:
    """Velocity of the cylinder [m/s] under the reaction to pressures, and to friction and end stops [N]."""
    if not options.foundation:
        return 0.0
    # (2b): the pressures push the cylinder opposite to the piston.
    force = resistance - force_of_pressures(state, p, options)
    velocity: float = foundation_velocity(state.support, force, p.support_stiffness, p.support_damping)
    return velocity
