"""Numbers out of range are shown as they are written; a share above one is asked for its percent sign."""

from __future__ import annotations

import pytest

from hydrofdi.config import load_experiment
from hydrofdi.detectors.trained.training import stated_detector
from hydrofdi.errors import ConfigError


@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ("supply.pressure=-21 MPa", "must be greater than 0; found -21 MPa"),
        ("supply.pressure=-21000000", "must be greater than 0; found -2.1e+07"),
        ("friction.viscous=-5 N·s/m", "must be at least 0; found -5 N·s/m"),
    ],
)
def test_a_value_out_of_range_is_shown_as_it_is_written(setting, sentence) -> None:
    with pytest.raises(ConfigError) as raised:
        load_experiment(settings=[setting])
    assert str(raised.value).endswith(sentence)


def test_a_rate_above_one_is_asked_for_its_percent_sign() -> None:
    with pytest.raises(ConfigError, match=r"must be at most 0\.5; found 5; write '5 %' if it is in percent"):
        stated_detector({"false_alarm_rate": 5, "direction": "both"}, {})
    with pytest.raises(ConfigError) as raised:
        stated_detector({"false_alarm_rate": "60 %", "direction": "both"}, {})
    assert str(raised.value).endswith("must be at most 0.5; found 60 %")
