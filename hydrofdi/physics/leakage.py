"""Leakage across the piston and out of the chambers."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation, signed_root

REFERENCE_DROP = 8e6
"""Pressure difference at which a leak is also stated, by default by indicators as well [Pa]."""


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
