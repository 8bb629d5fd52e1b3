"""Right-hand side: rates of the hydraulic states of a run."""

from __future__ import annotations

from collections import namedtuple
from typing import TYPE_CHECKING, Any, NamedTuple

from hydrofdi.physics.cylinder import (
    chamber_pressure_rates,
    end_stop_force,
    foundation_velocity,
    line_flow_rate,
    line_pressure_rate,
    piston_acceleration,
    pressure_force,
    supported_pressure_rate,
)
from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.fluid import effective_bulk_modulus, stiffening_bulk_modulus, temperature_factor
from hydrofdi.physics.friction import chosen_friction, dry_friction_factor
from hydrofdi.physics.leakage import (
    blended_leakage_flow,
    dragged_pressure_difference,
    external_leakage_flow,
    intermittent_onset,
    internal_leakage_flow,
    laminar_leakage_flow,
    onset_ramp,
    scored_share,
)
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
from hydrofdi.simulation.kernels.lanes import FRICTION_PARAMETERS, LEAKAGE, PARAMETERS, ModelOptions


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
    LaneFriction = Any
else:
    LaneFriction = namedtuple("LaneFriction", FRICTION_PARAMETERS)
    LaneParameters = namedtuple("LaneParameters", (*PARAMETERS, LEAKAGE))
    """Parameters of one run at an instant, in SI: the lane fields of the same names."""

_DRY = ("coulomb", "breakaway")
_SCALED = ", ".join(f"p.{name} * factor" if name in _DRY else f"p.{name}" for name in FRICTION_PARAMETERS)
scaled_friction = equation(eval(f"lambda p, factor: LaneFriction({_SCALED})"))
"""Parameters and factor on the dry friction → friction parameters."""

_WARMED = {
    "bulk_modulus": "lanes.bulk_modulus_slope[k]",
    **dict.fromkeys((name for name in PARAMETERS if "leakage" in name), "-lanes.viscosity_slope[k]"),
    **dict.fromkeys(("viscous", "leakage_drag"), "lanes.viscosity_slope[k]"),
}
"""Lane field → relative change per temperature [1/K]."""


def _warmed(name: str) -> str:
    """Expression of a lane field at the temperature of an instant."""
    temperature = "lanes.temperature_rise[k], lanes.temperature_drift[k]"
    return f"warmed(time, lanes.{name}[k], {temperature}, {_WARMED[name]}, options)"


_AT_AN_INSTANT = {name: _warmed(name) for name in _WARMED} | {
    "null_offset": "null_of(time, lanes.null_offset[k], lanes.null_drift[k], options)",
    "ripple": "ripple_of(middle, lanes.ripple[k], lanes.ripple_frequency[k], options)",
    LEAKAGE: "open_leakage(time, warmed_gap(time, lanes, k, options), lanes.onset_time[k],"
    " lanes.onset_duration[k], lanes.onset_duty[k], options)",
}
"""Lane field → its value where that changes over time."""

_FIELDS = (_AT_AN_INSTANT.get(name, f"lanes.{name}[k]") for name in (*PARAMETERS, LEAKAGE))
lane_parameters = equation(
    eval(f"lambda lanes, k, time, middle, options: LaneParameters({', '.join(_FIELDS)})")
)
"""Record of lanes, lane, start and middle of a step [s] and options → `LaneParameters`."""


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


@equation
def open_leakage(
    time: Quantity,
    coefficient: Quantity,
    start: Quantity,
    duration: Quantity,
    duty: Quantity,
    options: ModelOptions,
) -> Quantity:
    """K_i at an instant [m^3.5/kg^0.5]; it is constant over a step."""
    if options.ramped_leakage is not None:
        return coefficient * onset_ramp(time, start, duration)
    if options.intermittent_leakage is not None:
        return coefficient * intermittent_onset(time, start, duration, duty)
    return coefficient


@equation
def warmed(
    time: Quantity, value: Quantity, rise: Quantity, drift: Quantity, slope: Quantity, options: ModelOptions
) -> Quantity:
    """A property of the oil at the temperature of an instant; it is constant over a step."""
    return value if options.warm_oil is None else value * temperature_factor(time, rise, drift, slope)


@equation
def warmed_gap(time: Quantity, lanes: Any, k: Any, options: ModelOptions) -> Quantity:
    """K_i of the open leak at the temperature of an instant [m^3.5/kg^0.5]; only a laminar gap changes."""
    coefficient = lanes.internal_leakage[k]
    if options.laminar_leakage is None:
        return coefficient
    rise, drift = lanes.temperature_rise[k], lanes.temperature_drift[k]
    return warmed(time, coefficient, rise, drift, -lanes.viscosity_slope[k], options)


@equation
def chamber_2(p: LaneParameters, options: ModelOptions) -> tuple[float, float]:
    """Area [m²] and volume with the piston centred [m³] of chamber 2."""
    if options.unequal_chambers is None:
        return p.area, p.volume
    return p.area_2, p.volume_2


@equation
def force_of_pressures(state: State, p: LaneParameters, options: ModelOptions) -> float:
    """Force of the chamber pressures on the piston [N]."""
    # A (P_1 − P_2) and A P_1 − A P_2 round differently, and equal areas keep their bits.
    if options.unequal_chambers is None:
        return p.area * (state.pressure_1 - state.pressure_2)  # type: ignore[no-any-return]
    return pressure_force(state.pressure_1, state.pressure_2, p.area, p.area_2)  # type: ignore[no-any-return]


@equation
def position_in_cylinder(state: State, options: ModelOptions) -> float:
    """Position of the piston relative to the cylinder [m]."""
    return state.position if options.foundation is None else state.position - state.support


@equation
def friction_of(state: State, p: LaneParameters, options: ModelOptions) -> tuple[float, float]:
    """Friction force [N] and bristle rate [m/s] by the chosen law."""
    if options.uneven_friction is None:
        return chosen_friction(state.velocity, state.bristle, p, options.friction_law)  # type: ignore[no-any-return]
    difference, position = state.pressure_1 - state.pressure_2, position_in_cylinder(state, options)
    factor = dry_friction_factor(difference, position, p.pressure_slope, p.position_share, p.position_period)
    now = scaled_friction(p, factor)
    return chosen_friction(state.velocity, state.bristle, now, options.friction_law)  # type: ignore[no-any-return]


@equation
def null_of(time: Quantity, offset: Quantity, drift: Quantity, options: ModelOptions) -> Quantity:
    """Null position of the valve at an instant [m]; it is constant over a step."""
    return offset if options.shifted_null is None else null_position(time, offset, drift)


@equation
def ripple_of(time: Quantity, amplitude: Quantity, frequency: Quantity, options: ModelOptions) -> Quantity:
    """Rate of the supply pressure by the pump's ripple at an instant [Pa/s]: over a step, that of its
    middle."""
    return amplitude if options.supply_ripple is None else ripple_rate(time, amplitude, frequency)


@equation
def leakage_of(
    pressure_difference: Quantity,
    position: Quantity,
    velocity: Quantity,
    p: LaneParameters,
    options: ModelOptions,
) -> Quantity:
    """Internal leakage flow by the chosen law [m³/s]."""
    coefficient = p.internal_leakage
    if options.dragged_leakage is not None:
        pressure_difference = dragged_pressure_difference(pressure_difference, velocity, p.leakage_drag)
    if options.scored_bore is not None:
        coefficient = coefficient * scored_share(position, p.scored_centre, p.scored_width)
    if options.laminar_leakage is not None:
        return laminar_leakage_flow(pressure_difference, coefficient, p.laminar_reference)
    if options.blended_leakage is not None:
        return blended_leakage_flow(pressure_difference, coefficient, p.blending_pressure)
    return internal_leakage_flow(pressure_difference, coefficient)


@equation
def valve_flows(state: State, spool_position: float, p: LaneParameters, options: ModelOptions) -> ValveFlows:
    """Flows across the edges of the valve.

    With critical lap, only two of the four edges are open at a time, so two orifices suffice.
    """
    ret = p.ret if options.return_line is None else state.return_pressure
    port_1 = state.pressure_1 if options.hoses is None else state.line_pressure_1
    port_2 = state.pressure_2 if options.hoses is None else state.line_pressure_2
    if options.shifted_null is not None:
        spool_position = spool_position - p.null_offset
    if options.lapped_valve is not None:
        to_1, from_1 = state.supply - port_1, port_1 - ret
        to_2, from_2 = state.supply - port_2, port_2 - ret
        x, y = spool_position, -spool_position
        feed_1 = _edge(x, to_1, p.supply_1_lap, p.supply_1_leakage, p.supply_1_gain, p, options)
        drain_1 = _edge(y, from_1, p.return_1_lap, p.return_1_leakage, p.return_1_gain, p, options)
        feed_2 = _edge(y, to_2, p.supply_2_lap, p.supply_2_leakage, p.supply_2_gain, p, options)
        drain_2 = _edge(x, from_2, p.return_2_lap, p.return_2_leakage, p.return_2_gain, p, options)
        throttling = to_1 * feed_1 + from_1 * drain_1 + to_2 * feed_2 + from_2 * drain_2
        return ValveFlows(feed_1 - drain_1, drain_2 - feed_2, feed_1 + feed_2, drain_1 + drain_2, throttling)
    drop_1 = chamber_1_orifice_drop(spool_position, port_1, state.supply, ret)
    drop_2 = chamber_2_orifice_drop(spool_position, port_2, state.supply, ret)
    flow_1 = control_flow(spool_position, drop_1, p.flow_gain, p.area_gradient)
    flow_2 = control_flow(spool_position, drop_2, p.flow_gain, p.area_gradient)
    throttling = abs(drop_1 * flow_1) + abs(drop_2 * flow_2)
    opens_1 = spool_position >= 0.0
    return ValveFlows(
        flow_1, flow_2, flow_1 if opens_1 else -flow_2, flow_2 if opens_1 else -flow_1, throttling
    )


@equation
def _edge(
    spool_position: float,
    drop: float,
    lap: float,
    leakage: float,
    gain: float,
    p: LaneParameters,
    options: ModelOptions,
) -> float:
    lap, leakage, gain = p.lap + lap, p.lap_leakage + leakage, gain * p.flow_gain
    if options.worn_edges is not None:
        opening = worn_opening(spool_position - lap, p.edge_rounding, p.gain_slope)
        spool_position, lap = opening, 0.0
    flow: float = edge_flow(spool_position, drop, gain, p.area_gradient, lap, leakage)
    return flow


@equation
def port_flows(state: State, spool_position: float, p: LaneParameters, options: ModelOptions) -> PortFlows:
    """All flows into and out of the chambers."""
    valve = valve_flows(state, spool_position, p, options)
    into_1, from_2 = valve.control_1, valve.control_2
    if options.hoses is not None:
        into_1, from_2 = state.line_flow_1, state.line_flow_2
    position = position_in_cylinder(state, options)
    return PortFlows(
        valve,
        into_1,
        from_2,
        leakage_of(state.pressure_1 - state.pressure_2, position, state.velocity, p, options),
        external_leakage_flow(state.pressure_1, p.external_leakage_1),
        external_leakage_flow(state.pressure_2, p.external_leakage_2),
    )


@equation
def bulk_modulus_at(pressure: float, p: LaneParameters, options: ModelOptions) -> float:
    """β of the fluid in a chamber by the chosen law [Pa]."""
    modulus: float = p.bulk_modulus
    if options.stiffening is not None:
        modulus = stiffening_bulk_modulus(pressure, modulus, p.pressure_stiffening)
    if options.free_air is not None:
        modulus = effective_bulk_modulus(pressure, modulus, p.free_air, p.air_exponent, p.atmosphere)
    return modulus


@equation
def pressure_rates(
    state: State, net_1: float, net_2: float, p: LaneParameters, options: ModelOptions
) -> tuple[float, float]:
    """P_1' and P_2' from the net flows [m³/s] into the chambers [Pa/s]."""
    modulus = p.bulk_modulus
    if options.free_air is not None or options.stiffening is not None:
        net_1 *= bulk_modulus_at(state.pressure_1, p, options)
        net_2 *= bulk_modulus_at(state.pressure_2, p, options)
        modulus = 1.0
    position = position_in_cylinder(state, options)
    area_2, volume_2 = chamber_2(p, options)
    rate_1, rate_2 = chamber_pressure_rates(
        position, net_1, net_2, modulus, p.volume, volume_2, p.area, area_2
    )
    if options.clamped_cavitation is not None:
        rate_1 = supported_pressure_rate(state.pressure_1, rate_1, p.vapour_pressure)
        rate_2 = supported_pressure_rate(state.pressure_2, rate_2, p.vapour_pressure)
    return rate_1, rate_2


@equation
def hydraulic_rates(
    state: State, spool_position: float, load: float, p: LaneParameters, options: ModelOptions
) -> State:
    """Time derivatives of the state, at a spool position [m] and a load force [N]."""
    resistance, bristle = friction_of(state, p, options)
    reaction = resistance
    if options.load_force is not None:
        resistance += load
    if options.inclined is not None:
        resistance += p.weight
    if options.end_stops is not None:
        stopping = end_stop_force(position_in_cylinder(state, options), p.stop_position, p.stop_stiffness)
        resistance += stopping
        reaction += stopping
    support = support_velocity(state, reaction, p, options)
    flows = port_flows(state, spool_position, p, options)
    speed, area_2 = state.velocity - support, chamber_2(p, options)[0]
    net_1 = flows.into_1 - flows.internal - flows.external_1 - p.area * speed
    net_2 = flows.internal - flows.from_2 - flows.external_2 + area_2 * speed
    rate_1, rate_2 = pressure_rates(state, net_1, net_2, p, options)
    force = force_of_pressures(state, p, options)
    acceleration = piston_acceleration(state.position, force, resistance, p.mass, p.stiffness)
    supply, return_pressure = 0.0, 0.0
    if options.moving_supply is not None:
        supply = supply_pressure_rate(
            state.supply, flows.valve.supply, p.rated_supply, p.droop_resistance, p.droop_time
        )
    if options.supply_ripple is not None:
        supply += p.ripple
    if options.return_line is not None:
        return_pressure = return_pressure_rate(
            state.return_pressure, flows.valve.returned, p.ret, p.return_resistance, p.return_time
        )
    line_1, line_2, flow_1, flow_2 = 0.0, 0.0, 0.0, 0.0
    if options.hoses is not None:
        line_1 = line_pressure_rate(flows.valve.control_1 - flows.into_1, p.hose_modulus, p.hose_volume)
        line_2 = line_pressure_rate(flows.from_2 - flows.valve.control_2, p.hose_modulus, p.hose_volume)
        drop_1, drop_2 = state.line_pressure_1 - state.pressure_1, state.pressure_2 - state.line_pressure_2
        flow_1 = line_flow_rate(drop_1, state.line_flow_1, p.hose_resistance, p.hose_inertance)
        flow_2 = line_flow_rate(drop_2, state.line_flow_2, p.hose_resistance, p.hose_inertance)
    return State(
        state.velocity, acceleration, rate_1, rate_2, supply, bristle, return_pressure, support,
        line_1, flow_1, line_2, flow_2,
    )  # fmt: skip


@equation
def support_velocity(state: State, resistance: float, p: LaneParameters, options: ModelOptions) -> float:
    """Velocity of the cylinder [m/s] under the reaction to pressures, and to friction and end stops [N]."""
    if options.foundation is None:
        return 0.0
    force = resistance - force_of_pressures(state, p, options)
    velocity: float = foundation_velocity(state.support, force, p.support_stiffness, p.support_damping)
    return velocity
