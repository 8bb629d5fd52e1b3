"""Logarithm and power of two, and the modulus that is computed with them, against wider arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrofdi.physics.fluid import (
    LEAST_ABSOLUTE_PRESSURE,
    binary_exponential,
    binary_logarithm,
    effective_bulk_modulus,
)

ERROR = 1e-12
"""What both functions state."""

positive = st.floats(min_value=1e-300, max_value=1e300)
exponents = st.floats(min_value=-1000.0, max_value=1000.0)


@given(positive)
def test_logarithm_has_the_stated_error(value: float) -> None:
    assert abs(binary_logarithm(value) - math.log2(value)) < ERROR + 2e-16 * abs(math.log2(value))


@given(exponents)
def test_power_has_the_stated_error(exponent: float) -> None:
    assert binary_exponential(exponent) == pytest.approx(math.pow(2.0, exponent), rel=ERROR, abs=0.0)


def test_errors_hold_all_over_an_octave() -> None:
    mantissas, fractions = np.linspace(0.70, 1.42, 100_001), np.linspace(-0.51, 0.51, 100_001)
    assert np.abs(binary_logarithm(mantissas) - np.log2(mantissas)).max() < ERROR
    assert np.abs(binary_exponential(fractions) / np.exp2(fractions) - 1.0).max() < ERROR


@given(st.integers(min_value=-1000, max_value=1000))
def test_whole_powers_are_exact(exponent: int) -> None:
    assert Fraction(float(binary_exponential(float(exponent)))) == Fraction(2) ** exponent
    assert binary_logarithm(2.0**exponent) == exponent


@given(
    pressure=st.floats(min_value=-1e6, max_value=200e6),
    liquid=st.floats(min_value=10e6, max_value=10e9),
    free_air=st.floats(min_value=0.0, max_value=0.5),
    exponent=st.floats(min_value=1.0, max_value=10.0),
    atmosphere=st.floats(min_value=10e3, max_value=1e6),
)
def test_modulus_is_the_printed_equation_over_all_usual_values(
    pressure: float, liquid: float, free_air: float, exponent: float, atmosphere: float
) -> None:
    absolute = max(pressure + atmosphere, LEAST_ABSOLUTE_PRESSURE)
    liquid_volume = math.exp((atmosphere - absolute) / liquid)
    gas_volume = free_air * math.pow(atmosphere / absolute, 1.0 / exponent)
    slope = liquid_volume / liquid + gas_volume / (exponent * absolute)
    modulus = effective_bulk_modulus(pressure, liquid, free_air, exponent, atmosphere)
    assert modulus == pytest.approx((liquid_volume + gas_volume) / slope, rel=4.0 * ERROR, abs=0.0)


@pytest.mark.parametrize("pressure", [-1e12, -1e6, 0.0, 1e7, 1e12])
def test_modulus_of_absurd_pressures_is_finite_and_that_of_none_is_not(pressure: float) -> None:
    assert 0.0 < effective_bulk_modulus(pressure, 1.4e9, 0.01, 1.4, 101325.0) < math.inf
    assert np.isnan(effective_bulk_modulus(np.nan, 1.4e9, 0.01, 1.4, 101325.0))
