"""Piston motion and the pressures of the two chambers."""

from __future__ import annotations

from hydrofdi.physics.equation import Quantity, equation


@equation
def piston_acceleration(
    position: Quantity,
    pressure_1: Quantity,
    pressure_2: Quantity,
    friction: Quantity,
    mass: Quantity,
    area: Quantity,
    stiffness: Quantity,
) -> Quantity:
    """Acceleration of piston and load.

    Parameters
    ----------
    position : float or array
        x_p [m].
    pressure_1, pressure_2 : float or array
        P_1 and P_2 [Pa].
    friction : float or array
        F_f [N].
    mass, area, stiffness : float or array
        m [kg], A [m²] and K_ex [N/m].

    Returns
    -------
    float or array
        v_p' [m/s²]. Equation (2).
    """
    return (area * (pressure_1 - pressure_2) - friction - stiffness * position) / mass


@equation
def chamber_pressure_rates(
    position: Quantity,
    net_flow_1: Quantity,
    net_flow_2: Quantity,
    bulk_modulus: Quantity,
    volume: Quantity,
    area: Quantity,
) -> tuple[Quantity, Quantity]:
    """Rates of the two chamber pressures.

    Parameters
    ----------
    position : float or array
        x_p [m].
    net_flow_1, net_flow_2 : float or array
        Flow into each chamber less the rate at which the piston enlarges it [m³/s]:
        q_1 − q_il − q_el1 − A v_p and −q_2 + q_il − q_el2 + A v_p.
    bulk_modulus : float or array
        β [Pa].
    volume, area : float or array
        V [m³] of each chamber with the piston centred, and A [m²].

    Returns
    -------
    tuple of two float or array
        P_1' and P_2' [Pa/s]. Equations (5) and (6); one division serves both.
    """
    volume_1 = volume + area * position
    volume_2 = volume - area * position
    stiffness = bulk_modulus / (volume_1 * volume_2)
    return stiffness * volume_2 * net_flow_1, stiffness * volume_1 * net_flow_2
