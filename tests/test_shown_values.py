"""What varies, in readable units."""

import pytest

from hydrofdi.config.shown_values import shown_value


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("fluid.bulk_modulus", 689e6, "689 MPa"),
        ("fluid.bulk_modulus", {"uniform": [440.8e6, 661.2e6]}, "440.8 … 661.2 MPa"),
        ("supply.pressure", {"normal": [17.2e6, 1e5]}, "17.2 ± 0.1 MPa (normal)"),
        ("actuator.mass", {"lognormal": [12.3, 1.1]}, "12.3 kg, factor 1.1 (lognormal)"),
        ("fluid.bulk_modulus", {"lognormal": [551e6, 1.1]}, "551 MPa, factor 1.1 (lognormal)"),
        ("actuator.load_stiffness", 150e3, "150 kN/m"),
        ("friction.scale", {"uniform": [0.7, 1.3]}, "0.7 … 1.3"),
        ("input.seed", 1108995417, "1108995417"),
        ("input.seed", {"integers": [0, 4294967295]}, "0 … 4294967295"),
        ("friction.law", {"choice": ["lugre", "smooth"]}, "lugre or smooth"),
        ("pressure_1_sensor.bias", {"normal": [0.0, 25e3]}, "0 ± 25 kPa (normal)"),
    ],
)
def test_a_value_or_a_distribution_is_said_with_its_unit(name, value, text):
    assert shown_value(name, value) == text
