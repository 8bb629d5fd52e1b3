"""Bulk modulus of the fluid, and properties of hydraulic oils over temperature and pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hydrofdi.physics import Quantity, equation

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


KELVIN, REFERENCE = 273.15, 273.15 + 15.0
"""0 °C [K], and the temperature for which density is stated [K]."""

_WALTHER = 0.7
"""Constant of Walther's equation [mm²/s]."""

SECANT_SLOPE = 5.6
"""Rise of the secant bulk modulus per pressure [-]."""

COOLING = 0.0024 * math.log(10.0)
"""Relative fall of the bulk modulus per temperature [1/K]: 10^(−0.0024 θ)."""


def walther_viscosity(
    temperature: float, temperature_1: float, viscosity_1: float, temperature_2: float, viscosity_2: float
) -> float:
    """Kinematic viscosity at a temperature, from those at two others.

    Parameters
    ----------
    temperature, temperature_1, temperature_2 : float
        T, T_1 and T_2 [K].
    viscosity_1, viscosity_2 : float
        ν_1 at T_1 and ν_2 at T_2 [m²/s].

    Returns
    -------
    float
        ν [m²/s] with lg lg(ν + 0.7 mm²/s) = A − B lg T through both points. Walther (1931); ASTM D341.
    """
    # (o1): linear interpolation does not depend on the base, so natural logarithms serve; ν in mm²/s.
    first, second = (math.log(math.log(1e6 * each + _WALTHER)) for each in (viscosity_1, viscosity_2))
    share = math.log(temperature / temperature_1) / math.log(temperature_2 / temperature_1)
    return 1e-6 * (math.exp(math.exp(first + share * (second - first))) - _WALTHER)


def secant_bulk_modulus(temperature: float, pressure: float, viscosity_20: float) -> float:
    """Isentropic secant bulk modulus of a mineral oil without air.

    Parameters
    ----------
    temperature, pressure : float
        T [K] and gauge pressure P [Pa].
    viscosity_20 : float
        Kinematic viscosity at 20 °C and atmospheric pressure [m²/s].

    Returns
    -------
    float
        K_s = P V_0/(V_0 − V) = [1.57 + 0.15 lg(ν_20/(mm²/s))] 10^(−0.0024 (T/K − 293.15)) GPa + 5.6 P
        [Pa]. Hayward, *How to estimate the bulk modulus of hydraulic fluids*, Hydraulic Pneumatic Power,
        1970; within 5 % for mineral oils.
    """
    # (o2): K_s at 20 °C and atmospheric pressure [Pa], from ν in mm²/s.
    at_20 = 1e9 * (1.57 + 0.15 * math.log10(1e6 * viscosity_20))
    return at_20 * math.exp(-COOLING * (temperature - KELVIN - 20.0)) + SECANT_SLOPE * pressure


def tangent_bulk_modulus(secant: float, pressure: float) -> float:
    """Tangent bulk modulus −V dP/dV of a secant one that rises linearly with pressure.

    Parameters
    ----------
    secant, pressure : float
        K_s at the gauge pressure P [Pa].

    Returns
    -------
    float
        K_s (K_s − P)/(K_s − 5.6 P) [Pa], from V = V_0 (1 − P/K_s).
    """
    return secant * (secant - pressure) / (secant - SECANT_SLOPE * pressure)  # (o3)


@dataclass(frozen=True)
class Oil:
    """A hydraulic oil, as its data sheet describes it.

    Attributes
    ----------
    name : str
        Name as users write it.
    viscosity_40, viscosity_100 : float
        Kinematic viscosity at 40 and 100 °C [m²/s].
    density_15 : float
        Density at 15 °C [kg/m³].
    expansion : float
        Relative thermal expansion [1/K].
    pressure_viscosity : float
        Relative rise of the dynamic viscosity per pressure (Barus) [1/Pa]; mineral oils have 1.5e-8 to 2.5e-8
        between 30 and 60 °C (Stachowiak, Batchelor, *Engineering Tribology*, table 2.3).
    """

    name: str
    viscosity_40: float
    viscosity_100: float
    density_15: float
    expansion: float = 7e-4
    pressure_viscosity: float = 2e-8

    def kinematic_viscosity(self, temperature: float) -> float:
        """ν at a temperature [K] and atmospheric pressure [m²/s]."""
        points = KELVIN + 40.0, self.viscosity_40, KELVIN + 100.0, self.viscosity_100
        return walther_viscosity(temperature, *points)

    def secant(self, temperature: float, pressure: float) -> float:
        """Isentropic secant bulk modulus without air [Pa], at [K] and gauge [Pa]."""
        return secant_bulk_modulus(temperature, pressure, self.kinematic_viscosity(KELVIN + 20.0))

    def bulk_modulus(self, temperature: float, pressure: float) -> float:
        """Isentropic tangent bulk modulus without air [Pa], at [K] and gauge [Pa].

        `effective_bulk_modulus` adds air.
        """
        return tangent_bulk_modulus(self.secant(temperature, pressure), pressure)

    def density(self, temperature: float, pressure: float = 0.0) -> float:
        """ρ_15 (1 − α (T − 15 °C))/(1 − P/K_s) [kg/m³], at [K] and gauge [Pa]."""
        # Heated at atmospheric pressure first, then compressed: 1 − P/K_s is V/V_0.
        cold = self.density_15 * (1.0 - self.expansion * (temperature - REFERENCE))
        return cold / (1.0 - pressure / self.secant(temperature, pressure))

    def viscosity(self, temperature: float, pressure: float = 0.0) -> float:
        """Dynamic viscosity ρ ν e^(α_P P) [Pa·s], at [K] and gauge [Pa]."""
        at_rest = self.density(temperature) * self.kinematic_viscosity(temperature)
        return at_rest * math.exp(self.pressure_viscosity * pressure)


def _mineral(kind: str, *grades: tuple[int, float, float]) -> list[Oil]:
    return [Oil(f"{kind}{grade}", grade * 1e-6, hot * 1e-6, density) for grade, hot, density in grades]


OILS = {
    oil.name: oil
    for oil in (
        # ISO 3448 at 40 °C; at 100 °C for VI 100 and 150 (ASTM D2270); densities as on usual data sheets
        *_mineral("HLP", (22, 4.3, 865.0), (32, 5.4, 872.0), (46, 6.8, 877.0), (68, 8.7, 882.0)),
        *_mineral("HVLP", (22, 4.9, 862.0), (32, 6.3, 868.0), (46, 8.1, 872.0), (68, 10.9, 878.0)),
        # limits of MIL-PRF-5606H; expansion: Lee Company, table of fluids
        Oil("MIL-H-5606", 13.2e-6, 4.9e-6, 867.0, expansion=8.3e-4),
    )
}
"""Name → oil."""
