"""Stiffness of the fluid."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation

LEAST_ABSOLUTE_PRESSURE = 1e3
"""Absolute pressure below which the gas in the fluid grows no softer [Pa]; it has no pressure below zero."""


@equation
def effective_bulk_modulus(
    pressure: Quantity, liquid: Quantity, free_air: Quantity, exponent: Quantity, atmosphere: Quantity
) -> Quantity:
    """Bulk modulus of a liquid with free air in it.

    Liquid and gas share one pressure; neither dissolves into the other, and the temperature stays what it is.

    Parameters
    ----------
    pressure : float or array
        Chamber pressure P on the scale of the return pressure, where the atmosphere is zero [Pa].
    liquid : float or array
        Bulk modulus β_l of the liquid alone [Pa].
    free_air : float or array
        Volume X of the gas over that of the liquid at atmospheric pressure [-].
    exponent : float or array
        Polytropic exponent n of the gas [-].
    atmosphere : float or array
        Atmospheric pressure p_0 [Pa].

    Returns
    -------
    float or array
        β [Pa] = [E + X (p_0/p)^(1/n)] / [E/β_l + X (p_0/p)^(1/n)/(n p)], with p = P + p_0 and
        E = e^(−P/β_l): minus the volume over its slope. After Cho et al.
    """
    absolute = np.maximum(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    liquid_volume = np.exp((atmosphere - absolute) / liquid)
    gas_volume = free_air * (atmosphere / absolute) ** (1.0 / exponent)
    return (liquid_volume + gas_volume) / (liquid_volume / liquid + gas_volume / (exponent * absolute))
