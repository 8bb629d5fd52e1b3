"""Arguments with wrong values: one sentence in the words of Python."""

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


WRONG = [
    (lambda: hydrofdi.calibrate(), "name at least one flow, e.g. flows="),
    (lambda: hydrofdi.load_experiment({"name": "x"}, 5), "settings: expected {'fluid.bulk_modulus'"),
    (lambda: hydrofdi.load_experiment({"name": "x"}, [5]), "settings: expected {'fluid.bulk_modulus'"),
    (lambda: hydrofdi.sweep(FRAME), "expected a path, found a DataFrame"),
    (lambda: hydrofdi.measure(FRAME, **RATE)["dwt.d22"], "leave the sampling frequency out"),
    (lambda: hydrofdi.measure(FRAME)["dwt.d22"], "no column 'dwt.d22'; did you mean 'dwt.d2'?"),
    (lambda: hydrofdi.measure(WORDS), "column 'P1 [bar]' contains text; convert it to numbers"),
    (lambda: hydrofdi.inspect(WORDS), "column 'P1 [bar]' contains text; convert it to numbers"),
    (lambda: hydrofdi.measure(pandas.DataFrame()), "found no column of numbers"),
    (lambda: hydrofdi.measure(dataset("")), "'P1' has no unit; name it 'P1 [bar]'"),
    (lambda: hydrofdi.measure(dataset("kg")), "'P1' has the unit 'kg', which is not convertible to Pa"),
    (lambda: hydrofdi.measure(dataset("Bar")), "unknown unit 'Bar'; did you mean 'bar'?"),
    (lambda: hydrofdi.measure(dataset(5)), "unknown unit '5'; use one like 'Pa'"),
    (lambda: hydrofdi.measure(NOISE, unit="kg", **RATE), "unit: kg is not convertible to Pa"),
    (
        lambda: hydrofdi.train(NOISE, output="d2", direction="both", window="2 bar", **RATE),
        "window: '2 bar' has",
    ),
    (lambda: hydrofdi.inspect(NOISE, record="x", **RATE), "'hydrofdi measure' lists them"),
    (lambda: hydrofdi.simulate(levels=4.5), "wavelet.levels: expected an integer; found 4.5"),
]


@pytest.mark.parametrize(("call", "sentence"), WRONG, ids=[sentence for _, sentence in WRONG])
def test_a_wrong_call_is_refused_in_one_sentence(call, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        call()
    told = str(refused.value)
    assert sentence in told
    assert len(told.splitlines()) == 1
    assert "channels." not in told


def test_a_setting_may_be_one_text():
    assert hydrofdi.load_experiment({"name": "x"}, "fluid.bulk_modulus=1 GPa").fluid.bulk_modulus == 1e9


def test_an_unknown_setting_names_the_nearest():
    with pytest.raises(hydrofdi.HydrofdiError, match="'bulk_modulus'"):
        hydrofdi.simulate(bulk_modulos="1 GPa")


def test_a_column_that_is_missing_is_a_key_error_as_well():
    with pytest.raises(KeyError):
        hydrofdi.measure(FRAME)["none"]
