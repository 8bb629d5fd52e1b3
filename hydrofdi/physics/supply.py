"""The pump: a pressure that gives way to flow."""

from __future__ import annotations

from hydrofdi.physics.equation import Quantity, equation


@equation
def supply_pressure_rate(
    pressure: Quantity, flow: Quantity, rated: Quantity, resistance: Quantity, time_constant: Quantity
) -> Quantity:
    """Rate of a supply pressure that falls with the flow taken from it, with a lag.

    Parameters
    ----------
    pressure : float or array
        P_s at the valve [Pa].
    flow : float or array
        Flow q_s from the supply into the valve [m³/s].
    rated : float or array
        Supply pressure without flow [Pa].
    resistance : float or array
        Fall of the pressure per flow in the steady state, R_s [Pa·s/m³].
    time_constant : float or array
        τ_s [s].

    Returns
    -------
    float or array
        P_s' = (P_s0 − R_s q_s − P_s)/τ_s [Pa/s].
    """
    return (rated - resistance * flow - pressure) / time_constant
