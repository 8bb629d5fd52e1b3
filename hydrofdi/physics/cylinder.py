"""Piston motion and the pressures of the two chambers."""

from __future__ import annotations

import math

from hydrofdi.physics.equation import Quantity, equation, limited

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
