"""The presets of the extended Kalman filters are their defaults, written out."""

from pathlib import Path

import pytest

from hydrofdi.indicators.selection import load_indicators

DETECTORS = Path(__file__).parents[2] / "configs" / "detectors"


@pytest.mark.parametrize("name", ["ekf_joint", "ekf_innovation"])
def test_a_preset_states_the_defaults(name):
    (made,) = load_indicators(str(DETECTORS / f"{name.replace('_', '-')}.yaml")).values()
    usual = made.Options(supply="nominal").model_dump()
    for option, value in made.options.model_dump().items():
        expected = 0.03 if option == "supply_deviation" and value is not None else usual[option]
        assert value == (pytest.approx(expected) if isinstance(expected, float) else expected), option
