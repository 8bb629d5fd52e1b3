"""Bulk modulus of the fluid."""

from __future__ import annotations

import numpy as np

from hydrofdi.physics.equation import Quantity, equation
from hydrofdi.physics.powers_of_two import LN_2, binary_exponential, binary_logarithm

LEAST_ABSOLUTE_PRESSURE = 1e3
"""Lower limit of the absolute pressure that the gas law uses [Pa]."""


@equation
def effective_bulk_modulus(
    pressure: Quantity, liquid: Quantity, free_air: Quantity, exponent: Quantity, atmosphere: Quantity
) -> Quantity:
    """Effective bulk modulus of a liquid that contains free air.

    Liquid and gas have the same pressure. No gas dissolves or is released, and the temperature is constant.

    Parameters
    ----------
    pressure : float or array
        Chamber gauge pressure P [Pa].
    liquid : float or array
        Bulk modulus β_l of the liquid without air [Pa].
    free_air : float or array
        Ratio X of gas volume to liquid volume at atmospheric pressure [-].
    exponent : float or array
        Polytropic exponent n of the gas [-].
    atmosphere : float or array
        Atmospheric pressure p_0 [Pa].

    Returns
    -------
    float or array
        β [Pa] = [E + X (p_0/p)^(1/n)] / [E/β_l + X (p_0/p)^(1/n)/(n p)], with p = P + p_0 and
        E = e^(−P/β_l); this is −V dp/dV. After Cho et al. The gas-to-liquid ratio X (p_0/p)^(1/n)/E is
        limited to 2^64 X.
    """
    absolute = np.maximum(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    strain = absolute / liquid
    binary = (strain - atmosphere / liquid) / LN_2 - binary_logarithm(absolute / atmosphere) / exponent
    gas = free_air * binary_exponential(np.minimum(binary, 64.0))
    return absolute * (1.0 + gas) / (strain + gas / exponent)
