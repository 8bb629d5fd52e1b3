"""Piston motion, the pressures of the two chambers, and leakage across the piston and out of them."""

from __future__ import annotations

import math

import numpy as np

from hydrofdi.physics import Quantity, equation, limited, signed_root

STANDARD_GRAVITY = 9.80665
"""g [m/s²], ISO 80000-3."""


def axial_weight(mass: float, inclination: float) -> float:
    """Weight of piston and load along the axis, against extension.

    Parameters
    ----------
    mass, inclination : float
        m [kg] and angle φ of the axis above the horizontal [rad], positive if the rod points up.

    Returns
    -------
    float
        m g sin φ [N], g = 9.80665 m/s².
    """
    return mass * STANDARD_GRAVITY * math.sin(inclination)  # (2d)


@equation
def pressure_force(
    pressure_1: Quantity, pressure_2: Quantity, area_1: Quantity, area_2: Quantity
) -> Quantity:
    """Force of the two chamber pressures on a piston with unequal areas.

    Parameters
    ----------
    pressure_1, pressure_2 : float or array
        P_1 and P_2 [Pa].
    area_1, area_2 : float or array
        A_1 and A_2 [m²].

    Returns
    -------
    float or array
        A_1 P_1 − A_2 P_2 [N], positive if it extends the rod.
    """
    return area_1 * pressure_1 - area_2 * pressure_2  # (2c)


@equation
def piston_acceleration(
    position: Quantity, force: Quantity, resistance: Quantity, mass: Quantity, stiffness: Quantity
) -> Quantity:
    """Acceleration of piston and load.

    Parameters
    ----------
    position : float or array
        x_p [m].
    force : float or array
        Force of the pressures, A (P_1 − P_2) if the areas are equal [N].
    resistance : float or array
        Friction F_f plus load force, weight along the axis and end-stop force, if any [N].
    mass, stiffness : float or array
        m [kg] and K_ex [N/m].

    Returns
    -------
    float or array
        v_p' [m/s²]. Equation (2).
    """
    return (force - resistance - stiffness * position) / mass  # (2)


@equation
def chamber_pressure_rates(
    position: Quantity,
    net_flow_1: Quantity,
    net_flow_2: Quantity,
    bulk_modulus: Quantity,
    volume_1: Quantity,
    volume_2: Quantity,
    area_1: Quantity,
    area_2: Quantity,
) -> tuple[Quantity, Quantity]:
    """Rates of the two chamber pressures.

    Parameters
    ----------
    position : float or array
        x_p [m].
    net_flow_1, net_flow_2 : float or array
        Flow into each chamber minus the rate at which the piston enlarges it [m³/s]:
        q_1 − q_il − q_el1 − A_1 v_p and −q_2 + q_il − q_el2 + A_2 v_p.
    bulk_modulus : float or array
        β [Pa].
    volume_1, volume_2 : float or array
        V_1 and V_2 with the piston centred [m³].
    area_1, area_2 : float or array
        A_1 and A_2 [m²].

    Returns
    -------
    tuple of two float or array
        P_1' and P_2' [Pa/s]. Equations (5) and (6).
    """
    # Not +=, which would change an array of the caller.
    volume_1 = volume_1 + area_1 * position
    volume_2 = volume_2 - area_2 * position
    # One division serves both rates, β/V_1 = β V_2/(V_1 V_2): it costs more than the products it saves.
    stiffness = bulk_modulus / (volume_1 * volume_2)
    return stiffness * volume_2 * net_flow_1, stiffness * volume_1 * net_flow_2  # (5), (6)


@equation
def end_stop_force(position: Quantity, limit: Quantity, stiffness: Quantity) -> Quantity:
    """Force of the elastic end stops, opposing motion into them.

    Parameters
    ----------
    position : float
        x_p [m].
    limit : float
        Distance of each stop from the centre [m].
    stiffness : float
        k_stop [N/m].

    Returns
    -------
    float
        F_stop = k_stop (x_p − sat(x_p, ±limit)) [N].
    """
    # Between the stops, the limited position is the position itself: a difference of zero without a branch.
    return stiffness * (position - limited(position, limit))  # (2a)


@equation
def line_flow_rate(
    pressure_drop: Quantity, flow: Quantity, resistance: Quantity, inertance: Quantity
) -> Quantity:
    """Rate of the flow through a hose.

    Parameters
    ----------
    pressure_drop : float or array
        Pressure at the inlet minus that at the outlet [Pa].
    flow : float or array
        q_h from the inlet to the outlet [m³/s].
    resistance, inertance : float or array
        R_h [Pa·s/m³] and I_h [kg/m⁴].

    Returns
    -------
    float or array
        q_h' = (Δp − R_h q_h)/I_h [m³/s²].
    """
    return (pressure_drop - resistance * flow) / inertance  # (5d)


@equation
def line_pressure_rate(net_flow: Quantity, bulk_modulus: Quantity, volume: Quantity) -> Quantity:
    """Rate of the pressure of a hose at the valve.

    Parameters
    ----------
    net_flow : float or array
        Flow into the hose minus flow out of it [m³/s].
    bulk_modulus, volume : float or array
        Effective bulk modulus β_h of oil and wall [Pa], and volume V_h [m³].

    Returns
    -------
    float or array
        β_h Δq/V_h [Pa/s].
    """
    return bulk_modulus * net_flow / volume  # (5d)


@equation
def foundation_velocity(
    displacement: Quantity, force: Quantity, stiffness: Quantity, damping: Quantity
) -> Quantity:
    """Velocity of a cylinder whose mass is negligible, on a spring and a damper.

    Parameters
    ----------
    displacement : float or array
        x_b of the cylinder [m].
    force : float or array
        Force on the cylinder: friction and end-stop force minus that of the pressures [N].
    stiffness, damping : float or array
        K_b [N/m] and D_b [N·s/m].

    Returns
    -------
    float or array
        x_b' = (F − K_b x_b)/D_b [m/s].
    """
    return (force - stiffness * displacement) / damping  # (2b)


@equation
def internal_leakage_flow(pressure_difference: Quantity, coefficient: Quantity) -> Quantity:
    """Flow from chamber 1 to chamber 2 across the piston seal (orifice law).

    Parameters
    ----------
    pressure_difference : float or array
        P_1 − P_2 [Pa].
    coefficient : float or array
        K_i [m^3.5/kg^0.5].

    Returns
    -------
    float or array
        q_il [m³/s]. Equation (11).
    """
    return coefficient * signed_root(pressure_difference)  # (11)


@equation
def laminar_leakage_flow(
    pressure_difference: Quantity, coefficient: Quantity, reference: Quantity
) -> Quantity:
    """Laminar leakage flow that equals the orifice flow at a reference pressure difference.

    Parameters
    ----------
    pressure_difference : float or array
        P_1 − P_2 [Pa].
    coefficient : float or array
        K_i of the orifice [m^3.5/kg^0.5].
    reference : float or array
        Pressure difference Δp_ref at which both laws give the same flow [Pa].

    Returns
    -------
    float or array
        q_il = K_i (P_1 − P_2)/√Δp_ref [m³/s].
    """
    return coefficient * pressure_difference / np.sqrt(reference)  # (11a)


@equation
def blended_leakage_flow(
    pressure_difference: Quantity, coefficient: Quantity, blending_pressure: Quantity
) -> Quantity:
    """Orifice flow with a finite slope at zero pressure difference.

    Parameters
    ----------
    pressure_difference : float or array
        P_1 − P_2 [Pa].
    coefficient : float or array
        K_i [m^3.5/kg^0.5].
    blending_pressure : float or array
        Δp_small [Pa]; the flow is linear well below it and follows the orifice law well above it.

    Returns
    -------
    float or array
        q_il = K_i ΔP/(ΔP² + Δp_small²)^¼ [m³/s].
    """
    # Two roots in series give the power ¼ without a power function; Δp_small keeps the divisor above zero.
    size = np.sqrt(pressure_difference * pressure_difference + blending_pressure * blending_pressure)
    return coefficient * pressure_difference / np.sqrt(size)  # (11b)


@equation
def dragged_pressure_difference(
    pressure_difference: Quantity, velocity: Quantity, drag: Quantity
) -> Quantity:
    """Pressure difference that drives the flow through the gap of a moving piston.

    Parameters
    ----------
    pressure_difference : float or array
        P_1 − P_2 [Pa].
    velocity : float or array
        v_p [m/s].
    drag : float or array
        d = 6 μ L/h² of a gap of height h and length L [Pa·s/m].

    Returns
    -------
    float or array
        P_1 − P_2 + d v_p [Pa]: the sum of Poiseuille and Couette flow in a plane gap.
    """
    return pressure_difference + drag * velocity  # (11e)


@equation
def scored_share(position: Quantity, centre: Quantity, width: Quantity) -> Quantity:
    """Share of a leak that is open where the bore is scored.

    Parameters
    ----------
    position : float or array
        x_p [m].
    centre, width : float or array
        Middle and length of the scored part of the stroke [m]; an infinite length is the whole stroke.

    Returns
    -------
    float or array
        1/(1 + (2 (x_p − x_c)/l)^8) [-]: near 1 within, ½ at the ends, near 0 outside.
    """
    # Squared three times for the eighth power; an infinite length gives u = 0 and a share of 1.
    u = 2.0 * (position - centre) / width
    u = u * u
    u = u * u
    return 1.0 / (1.0 + u * u)  # (11f)


@equation
def onset_ramp(time: Quantity, start: Quantity, duration: Quantity) -> Quantity:
    """Open fraction of the leak: rises from 0 at `start` to 1 within `duration` [-]; times in s."""
    return np.minimum(np.maximum((time - start) / duration, 0.0), 1.0)  # (11c)


@equation
def external_leakage_flow(pressure: Quantity, coefficient: Quantity) -> Quantity:
    """Flow out of a chamber to the surroundings.

    Parameters
    ----------
    pressure : float or array
        Chamber pressure [Pa].
    coefficient : float or array
        K_e [m³/(s·Pa)].

    Returns
    -------
    float or array
        q_el [m³/s]. Equations (9) and (10).
    """
    return coefficient * pressure  # (9), (10)
