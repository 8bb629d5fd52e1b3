"""Bulk modulus of the fluid."""

from __future__ import annotations

import math

import numpy as np

from hydrofdi.physics.equation import Quantity, equation

LN_2 = math.log(2.0)

_ROOT_HALF = 0x3FE6A09E667F3BCD
"""Bits of √½."""

_COUNTER, _COUNTER_BITS = 1.5 * 2.0**52, 0x4338000000000000
"""A double whose last bits count integers, and its bit pattern."""


@equation
def _bits(number: Quantity) -> Quantity:
    return (np.float64(number) if isinstance(number, float) else number).view(np.int64)


@equation
def _number(bits: Quantity) -> Quantity:
    return bits.view(np.float64)


@equation
def binary_logarithm(value: Quantity) -> Quantity:
    """log2(x) for a normal x > 0, with an error below 1e-12.

    With x = 2^k m, √½ ≤ m < √2 and z = (m − 1)/(m + 1), log2(x) = k + 2 artanh(z)/ln 2; the series is
    truncated after z^13.
    """
    bits = _bits(value)
    # The exponent of x/√½, rounded down by the arithmetic shift, so that the mantissa lies in √½ … √2.
    exponent = (bits - _ROOT_HALF) >> 52
    # Subtracting k from the bits of the exponent divides by 2^k without rounding.
    mantissa = _number(bits - (exponent << 52))
    # abs(z) ≤ 0.172, so the powers of its square fall fast.
    z = (mantissa - 1.0) / (mantissa + 1.0)
    u = z * z
    series = 1.0 / 7.0 + u * (1.0 / 9.0 + u * (1.0 / 11.0 + u * (1.0 / 13.0)))
    series = 1.0 + u * (1.0 / 3.0 + u * (1.0 / 5.0 + u * series))
    # k becomes a double by the counter, whose spacing is 1: its bits are added, and the offset subtracted.
    return (_number(exponent + _COUNTER_BITS) - _COUNTER) + (2.0 / LN_2) * z * series


@equation
def binary_exponential(exponent: Quantity) -> Quantity:
    """2^y for abs(y) ≤ 1000, with a relative error below 1e-12.

    With y = k + f, k an integer and abs(f) ≤ ½, 2^y = 2^k e^(f ln 2); the series is truncated after the tenth
    power.
    """
    # The sum rounds y to the nearest integer k, which remains in its last bits; needs no reassociation.
    counter = exponent + _COUNTER
    # f ln 2, within ±0.347.
    w = (exponent - (counter - _COUNTER)) * LN_2
    series = 1.0 / 5040.0 + w * (1.0 / 40320.0 + w * (1.0 / 362880.0 + w * (1.0 / 3628800.0)))
    series = 1.0 / 24.0 + w * (1.0 / 120.0 + w * (1.0 / 720.0 + w * series))
    series = 1.0 + w * (1.0 + w * (0.5 + w * (1.0 / 6.0 + w * series)))
    # The shift leaves only k, and adds it to the exponent of the series: a product with 2^k.
    return _number(_bits(series) + (_bits(counter) << 52))


LEAST_ABSOLUTE_PRESSURE = 1e3
"""Lower limit of the absolute pressure that the gas law uses [Pa]."""


@equation
def stiffening_bulk_modulus(pressure: Quantity, modulus: Quantity, slope: Quantity) -> Quantity:
    """Bulk modulus of a liquid that stiffens under pressure.

    Parameters
    ----------
    pressure : float or array
        Chamber gauge pressure P [Pa].
    modulus : float or array
        Bulk modulus β_0 at the pressure zero [Pa].
    slope : float or array
        Rise m of the (tangent) bulk modulus per pressure [-].

    Returns
    -------
    float or array
        β = β_0 + m max(P, 0) [Pa], so that V/V_0 = (1 + m P/β_0)^(−1/m). Murnaghan, *The compressibility of
        media under extreme pressures*, Proc. Natl. Acad. Sci. 30, 1944.
    """
    return modulus + slope * np.maximum(pressure, 0.0)  # (5e)


@equation
def effective_bulk_modulus(
    pressure: Quantity, liquid: Quantity, free_air: Quantity, exponent: Quantity, atmosphere: Quantity
) -> Quantity:
    """Effective bulk modulus of a liquid that contains free air.

    Liquid and gas have the same pressure. No gas dissolves or is released.

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
    # The floor keeps logarithm and quotient finite where the model falls below vacuum.
    absolute = np.maximum(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    strain = absolute / liquid
    # (5a) over E in numerator and denominator: P/β_l and the gas law join in one exponent, to the base 2.
    binary = (strain - atmosphere / liquid) / LN_2 - binary_logarithm(absolute / atmosphere) / exponent
    # The limit keeps the exponential in its range while a run diverges.
    gas = free_air * binary_exponential(np.minimum(binary, 64.0))
    # Numerator and denominator times p, as p/β_l is known: one division fewer.
    return absolute * (1.0 + gas) / (strain + gas / exponent)


@equation
def temperature_factor(time: Quantity, rise: Quantity, drift: Quantity, slope: Quantity) -> Quantity:
    """Factor on a property of oil at its temperature.

    Parameters
    ----------
    time : float or array
        Time t since the start of the record [s].
    rise : float or array
        Temperature θ_0 at t = 0 above that for which the property is given [K].
    drift : float or array
        Drift rate r_θ of the temperature [K/s].
    slope : float or array
        Relative change k of the property per temperature [1/K].

    Returns
    -------
    float or array
        e^(k (θ_0 + r_θ t)) [-].
    """
    return binary_exponential(slope * (rise + drift * time) / LN_2)  # (5c)
