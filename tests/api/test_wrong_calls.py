"""Calls with wrong values are refused in one line."""

from __future__ import annotations

import numpy as np
import pandas
import pytest
import xarray

import hydrofdi

RATE = {"sampling_frequency": "1 kHz"}
NOISE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal((3, 500))
FRAME = pandas.DataFrame({"time [s]": np.arange(500) / 1000.0, "P1 [bar]": NOISE[0] / 1e5})
WORDS = FRAME.assign(**{"P1 [bar]": "high"})


def dataset(unit):
    seconds = ("time", np.arange(500) / 1000.0, {"units": "s"})
    return xarray.Dataset({"P1": ("time", NOISE[0], {"units": unit})}, coords={"time": seconds})


@pytest.mark.parametrize(
    "call",
    [
        lambda: hydrofdi.calibrate(),
        lambda: hydrofdi.load_experiment({"name": "x"}, 5),
        lambda: hydrofdi.load_experiment({"name": "x"}, [5]),
        lambda: hydrofdi.sweep(FRAME),
        lambda: hydrofdi.measure(FRAME, **RATE),
        lambda: hydrofdi.measure(FRAME)["dwt.d22"],
        lambda: hydrofdi.measure(WORDS),
        lambda: hydrofdi.measure(pandas.DataFrame()),
        lambda: hydrofdi.measure([FRAME, pandas.DataFrame({"torque [N·m]": [1.0, 2.0]})]),
        *(lambda unit=unit: hydrofdi.measure(dataset(unit)) for unit in ("", "kg", "Bar", 5)),
        lambda: hydrofdi.measure(NOISE, unit="kg", **RATE),
        lambda: hydrofdi.train(NOISE, output="d2", direction="both", window="2 bar", **RATE),
        lambda: hydrofdi.train(NOISE, config={"window": 2}, **RATE),
        lambda: hydrofdi.inspect(NOISE, record="x", **RATE),
        lambda: hydrofdi.simulate(levels=4.5),
        lambda: hydrofdi.simulate(supply_pressure="16 MPa"),
    ],
)
def test_a_wrong_call_is_refused_in_one_sentence(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        call()
    assert len(str(refused.value).splitlines()) == 1


def test_a_column_that_is_missing_is_a_key_error_as_well():
    with pytest.raises(KeyError):
        hydrofdi.measure(FRAME)["none"]
