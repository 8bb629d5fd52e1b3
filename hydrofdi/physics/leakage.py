"""Leakage across the piston and out of the chambers."""

from __future__ import annotations

from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.signed_root import signed_root


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
    return coefficient * signed_root(pressure_difference)


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
    return coefficient * pressure
