"""Stiffness of the fluid."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.powers_of_two import LN_2, binary_exponential, binary_logarithm

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
        E = e^(−P/β_l): minus the volume over its slope. After Cho et al. Computed from the ratio of the gas
        to the liquid, X (p_0/p)^(1/n)/E, which is taken as at most 2^64 X.
    """
    absolute = np.maximum(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    strain = absolute / liquid
    binary = (strain - atmosphere / liquid) / LN_2 - binary_logarithm(absolute / atmosphere) / exponent
    gas = free_air * binary_exponential(np.minimum(binary, 64.0))
    return absolute * (1.0 + gas) / (strain + gas / exponent)
