"""Supply pressure that drops with flow."""

from __future__ import annotations

from hydrofdi.physics.equation import Quantity, equation


@equation
def supply_pressure_rate(
    pressure: Quantity, flow: Quantity, rated: Quantity, resistance: Quantity, time_constant: Quantity
) -> Quantity:
    """Rate of a supply pressure that drops with the flow drawn, with a first-order lag.

    Parameters
    ----------
    pressure : float or array
        P_s at the valve [Pa].
    flow : float or array
        Flow q_s from the supply into the valve [m³/s].
    rated : float or array
        Supply pressure P_s0 at zero flow [Pa].
    resistance : float or array
        Source resistance R_s: pressure drop per flow in steady state [Pa·s/m³].
    time_constant : float or array
        τ_s [s].

    Returns
    -------
    float or array
        P_s' = (P_s0 − R_s q_s − P_s)/τ_s [Pa/s].
    """
    return (rated - resistance * flow - pressure) / time_constant
