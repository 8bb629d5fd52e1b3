"""An indicator with options is said in the same way to `measure`, `evaluate` and `train`."""

import numpy as np
import pytest

import hydrofdi

HEALTHY = 5e6 + 1e4 * np.random.default_rng(1).standard_normal((120, 500))
SAID = {"sampling_frequency": "1 kHz"}
WANTED = {"output": "d2", "direction": "both", "false_alarm_rate": "5 %", **SAID}
OPTIONS = {"name": "db4"}


@pytest.mark.parametrize(
    "form",
    [
        ({"dwt": OPTIONS}, {}),
        ({"mine": {"kind": "dwt", **OPTIONS}}, {}),
        ({"indicator": "dwt", "options": OPTIONS}, {}),
        ("dwt", {"options": OPTIONS}),
        (None, {"config": {"indicators": {"dwt": OPTIONS}}}),
    ],
)
def test_every_form_trains_the_same_detector(form):
    indicator, more = form
    wanted = hydrofdi.train(HEALTHY, config={"indicator": "dwt", "options": OPTIONS}, **WANTED)
    found = hydrofdi.train(HEALTHY, indicator, **more, **WANTED)
    assert found.file.limits == wanted.file.limits
    assert found.file.limits != hydrofdi.train(HEALTHY, "dwt", **WANTED).file.limits


def test_what_measure_takes_train_takes():
    for form in ({"dwt": OPTIONS}, ["dwt"], "dwt"):
        assert "dwt.d2" in hydrofdi.measure(HEALTHY, form, **SAID).units
        assert hydrofdi.train(HEALTHY, form, **WANTED).file.config.indicator == "dwt"


def test_measure_takes_options_beside_the_name():
    beside = hydrofdi.measure(HEALTHY, "dwt", options={"levels": 3}, sampling_frequency="1 kHz")
    within = hydrofdi.measure(HEALTHY, {"dwt": {"levels": 3}}, sampling_frequency="1 kHz")
    assert "dwt.d3" in beside.columns
    assert beside.to_dict() == within.to_dict()


@pytest.mark.parametrize("indicators", ["all", "dwt,ring_down", ["dwt"], {"dwt": {}}])
def test_options_of_several_indicators_are_refused(indicators):
    with pytest.raises(hydrofdi.HydrofdiError, match="options: are for one named indicator"):
        hydrofdi.measure(HEALTHY, indicators, options={"levels": 3}, sampling_frequency="1 kHz")


def test_a_mistake_in_options_names_the_option():
    with pytest.raises(hydrofdi.HydrofdiError, match="did you mean 'levels'"):
        hydrofdi.measure(HEALTHY, "dwt", options={"levls": 3}, sampling_frequency="1 kHz")
