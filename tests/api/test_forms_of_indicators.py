"""An indicator with options is said in the same way to `measure`, `evaluate` and `train`."""

from __future__ import annotations

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
def test_every_form_trains_the_same_detector(form) -> None:
    indicator, more = form
    wanted = hydrofdi.train(HEALTHY, config={"indicator": "dwt", "options": OPTIONS}, **WANTED)
    found = hydrofdi.train(HEALTHY, indicator, **more, **WANTED)
    assert found.file.limits == wanted.file.limits
    assert found.file.limits != hydrofdi.train(HEALTHY, "dwt", **WANTED).file.limits


def test_what_measure_takes_train_takes() -> None:
    for form in ({"dwt": OPTIONS}, ["dwt"], "dwt"):
        assert "dwt.d2" in hydrofdi.measure(HEALTHY, form, **SAID).units
        assert hydrofdi.train(HEALTHY, form, **WANTED).file.config.indicator == "dwt"
