"""Oils: published points, monotone laws, and a name for each grade."""

import math

import numpy as np
import pytest

from hydrofdi.config.data_sheet import named_oil
from hydrofdi.physics.fluid import KELVIN, OILS

TEMPERATURES = KELVIN + np.arange(-10.0, 91.0, 10.0)


@pytest.mark.parametrize("name", [name for name in OILS if name[-2:].isdigit() and "LP" in name])
def test_the_grade_is_the_viscosity_at_40_and_the_index_that_at_100_degrees(name):
    grade = float(name.lstrip("HVLP"))
    cold, hot = (1e6 * OILS[name].kinematic_viscosity(KELVIN + each) for each in (40.0, 100.0))
    assert cold == pytest.approx(grade, rel=1e-12)
    # ASTM D2270, H of oils with VI 100 at this viscosity at 100 °C (points of its table, interpolated)
    points = [4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 11.0]
    of_100 = np.interp(hot, points, [19.56, 28.49, 38.19, 48.57, 59.60, 82.87, 95.19])
    index = 100.0 + ((of_100 / grade) ** (1.0 / math.log10(hot)) - 1.0) / 0.00715
    assert index == pytest.approx(150.0 if name.startswith("HV") else 100.0, abs=6.0)


@pytest.mark.parametrize("oil", OILS.values(), ids=lambda oil: oil.name)
def test_warm_oil_is_thinner_lighter_and_softer_and_its_modulus_the_slope_of_its_volume(oil):
    for quantity in (oil.viscosity, oil.density, oil.bulk_modulus):
        assert (np.diff([quantity(each, 1e7) for each in TEMPERATURES]) < 0.0).all()
        assert (np.diff([quantity(KELVIN + 40.0, each) for each in np.linspace(0.0, 4e7, 9)]) > 0.0).all()
    warm, pressure, step = KELVIN + 45.0, 2e7, 1e3
    low, high = (1.0 - each / oil.secant(warm, each) for each in (pressure - step, pressure + step))
    tangent = -(low + high) * step / (high - low)
    assert oil.bulk_modulus(warm, pressure) == pytest.approx(tangent, rel=1e-6)
    assert oil.secant(warm, 0.0) == oil.bulk_modulus(warm, 0.0)


def test_aviation_oil_has_the_bulk_modulus_of_a_table_of_fluids():
    """260,000 psi (Lee Company, *Lohms laws*, table of fluids)."""
    assert OILS["MIL-H-5606"].bulk_modulus(KELVIN + 20.0, 0.0) == pytest.approx(260e3 * 6894.757, rel=0.05)


def test_an_oil_has_several_spellings_three_numbers_are_one_and_nothing_else_is():
    spelt = {
        "HLP46": "hlp 46", "HLP32": "ISO VG 32", "HLP68": "HM-68", "HVLP46": "HV 46", "MIL-H-5606": "H-515",
    }  # fmt: skip
    assert {name: named_oil(text) for name, text in spelt.items()} == {name: OILS[name] for name in spelt}
    assert named_oil("mil-prf-5606") is OILS["MIL-H-5606"]
    oil, same = named_oil("46 cSt, 6.8 mm²/s, 0.877 g/cm³"), OILS["HLP46"]
    assert oil.viscosity(KELVIN + 60.0) == pytest.approx(same.viscosity(KELVIN + 60.0), rel=1e-12)
    for text in ("HLP47", "water", "46 cSt", "6.8 cSt, 46 cSt, 877 kg/m³", "46 cSt, 6.8 cSt, 877 Pa"):
        with pytest.raises(ValueError, match=r"oil|unit"):
            named_oil(text)
