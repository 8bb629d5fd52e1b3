"""`options=` belongs to one named indicator, in `measure` and `evaluate` as in `train`."""

import numpy as np
import pytest

import hydrofdi

PRESSURE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal((150, 1000))


def test_measure_takes_options_beside_the_name():
    beside = hydrofdi.measure(PRESSURE, "dwt", options={"levels": 3}, sampling_frequency="1 kHz")
    within = hydrofdi.measure(PRESSURE, {"dwt": {"levels": 3}}, sampling_frequency="1 kHz")
    assert "dwt.d3" in beside.columns
    assert beside.to_dict() == within.to_dict()


@pytest.mark.parametrize("indicators", ["all", "dwt,ring_down", ["dwt"], {"dwt": {}}])
def test_options_of_several_indicators_are_refused(indicators):
    with pytest.raises(hydrofdi.HydrofdiError, match="options: are for one named indicator"):
        hydrofdi.measure(PRESSURE, indicators, options={"levels": 3}, sampling_frequency="1 kHz")


def test_a_mistake_in_options_names_the_option():
    with pytest.raises(hydrofdi.HydrofdiError, match="did you mean 'levels'"):
        hydrofdi.measure(PRESSURE, "dwt", options={"levls": 3}, sampling_frequency="1 kHz")
