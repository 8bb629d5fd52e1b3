"""Every verdict and every failure names keys that exist, and turning them helps."""

from __future__ import annotations

import re
from typing import Any

import pytest

from hydrofdi.config import ExperimentConfig, RunParameters
from hydrofdi.config.request import parameter_names
from hydrofdi.execution import Job, compute_columns
from hydrofdi.quality.doubts import DOUBTS, REMEDIES

_SHORT = RunParameters().with_values({"record.duration": 8.0, "input.period": 0.5})
_WIDE = {"input.amplitude": 8.0}
_DRIFTING = {"input.period": 2.0}
_FREE = {"actuator.load_stiffness": 0.0, "input.amplitude": 8.0, "input.period": 2.0}


def _verdict(values: dict[str, Any], coefficient: float) -> str:
    columns = compute_columns([Job("run", _SHORT.with_values(values), coefficient)])
    return str(columns["verdict"][0])


@pytest.mark.parametrize(
    ("word", "values", "turned", "coefficient"),
    [
        ("cavitating", _WIDE, {"input.amplitude": 2.0}, 4e-9),
        ("above_supply", _WIDE | {"supply.return_pressure": 3e6}, {"supply.pressure": 25e6}, 4e-9),
        ("unsettled", _DRIFTING, {"record.duration": 20.0}, 0.0),
        ("clipped", {"pressure_1_sensor.highest": 9e6}, {"pressure_1_sensor.highest": 25e6}, 4e-9),
        ("still", {"valve.lap": 50e-6}, {"input.amplitude": 5.0}, 4e-9),
        ("stroke_exceeded", _FREE, {"input.period": 0.5}, 4e-9),
        ("diverged", {"record.step": 1e-3, "fluid.bulk_modulus": 1e11}, {"record.step": 1e-5}, 4e-9),
    ],
)
def test_what_a_remedy_names_takes_the_verdict_away(
    word: str, values: dict[str, Any], turned: dict[str, Any], coefficient: float
) -> None:
    told = REMEDIES.get(word, "") or DOUBTS[word].remedy
    assert all(key in told for key in turned)
    assert word in _verdict(values, coefficient).split(", ")
    assert word not in _verdict(values | turned, coefficient).split(", ")


@pytest.mark.parametrize("told", [*(doubt.remedy for doubt in DOUBTS.values()), *REMEDIES.values()])
def test_remedies_name_keys_that_exist(told: str) -> None:
    known = {*parameter_names(), *(f"limits.{key}" for key in ExperimentConfig().limits.model_dump())}
    assert set(re.findall(r"\b(?!hydrofdi\.)[a-z_0-9]+\.[a-z_]+\b", told)) <= known
