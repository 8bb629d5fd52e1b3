"""Steady state of valve and cylinder: pressures at rest, speeds of both directions, and pressure gain."""

from __future__ import annotations

import math


def rest_pressures(
    supply: float, ret: float, area_1: float, area_2: float, force: float
) -> tuple[float, float]:
    """Chamber pressures while a servovalve with equal edges holds the piston at rest.

    Through each chamber the same flow passes its supply and its return edge, one of which the spool opens as
    far as it shuts the other. So the drops at the edges of chamber 1 have the inverse ratio of those of
    chamber 2, and P_1 + P_2 = P_s + P_r, whatever the lap. Edges of different chambers may differ.

    Parameters
    ----------
    supply, ret : float
        P_s and P_r [Pa].
    area_1, area_2 : float
        A_1 and A_2 [m²].
    force : float
        Constant force F against extension [N].

    Returns
    -------
    tuple of float
        P_1 = (A_2 (P_s + P_r) + F)/(A_1 + A_2), P_2 = (A_1 (P_s + P_r) − F)/(A_1 + A_2) [Pa]; no lower than
        P_r and no higher than P_s, which a larger force would need.
    """
    total, areas = supply + ret, area_1 + area_2
    pressures = (area_2 * total + force) / areas, (area_1 * total - force) / areas  # (r1)
    first, second = (min(max(pressure, ret), supply) for pressure in pressures)
    return first, second


def steady_speed(
    supply: float,
    ret: float,
    area_in: float,
    area_out: float,
    conductance_in: float,
    conductance_out: float,
    force: float,
) -> float:
    """Speed of a piston under constant opening and force, without leakage.

    Parameters
    ----------
    supply, ret : float
        P_s and P_r [Pa].
    area_in, area_out : float
        Areas of the chamber that is fed and of the one that is drained [m²].
    conductance_in, conductance_out : float
        K_v w x of the open edges: flow over √Δp [m³/(s·√Pa)].
    force : float
        F against the motion [N].

    Returns
    -------
    float
        v = √[(A_in P_s − A_out P_r − F)/(A_in³/k_in² + A_out³/k_out²)] [m/s]; 0 if the force is too large.
    """
    # (r2): each edge takes Δp = (A v/k)², a force A³ v²/k² on the piston.
    excess = area_in * supply - area_out * ret - force
    return math.sqrt(max(excess, 0.0) / (area_in**3 / conductance_in**2 + area_out**3 / conductance_out**2))


def pressure_gain(area_ratio: float, gains: tuple[float, float], coefficients: tuple[float, float]) -> float:
    """Change of the load pressure per spool travel at the null, with the piston blocked.

    Parameters
    ----------
    area_ratio : float
        A_2/A_1 [-].
    gains : tuple of float
        Flow gain K_q = K_v w √Δp of the edge that opens, for chambers 1 and 2 [m²/s].
    coefficients : tuple of float
        Flow-pressure coefficient K_c of each chamber: clearances and external leakage [m³/(s·Pa)].

    Returns
    -------
    float
        K_p = K_q1/K_c1 + (A_2/A_1) K_q2/K_c2 [Pa/m], the slope of P_1 − P_2 A_2/A_1; infinite without
        clearance. Merritt, *Hydraulic Control Systems*, 1967, ch. 5, for each chamber.
    """
    # (r3)
    first, second = (
        gain / coefficient if coefficient else math.inf
        for gain, coefficient in zip(gains, coefficients, strict=True)
    )
    return first + area_ratio * second
