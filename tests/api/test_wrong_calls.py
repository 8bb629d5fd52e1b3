"""Calls with wrong values are refused in one line; missing samples and labels are missing."""

import numpy as np
import pandas
import pytest
import xarray

import hydrofdi

RATE = {"sampling_frequency": "1 kHz"}
NOISE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal((200, 500))
STUDY = {
    "name": "asked",
    "record": {"duration": "2 s"},
    "sweep": {"grid": {"fluid.bulk_modulus": ["551 MPa"]}},
}

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
        lambda: hydrofdi.measure(NOISE),
        lambda: hydrofdi.measure(NOISE, sampling_frequency="1 kHZ"),
        lambda: hydrofdi.measure(NOISE, sampling_frequency=0),
        lambda: hydrofdi.measure(FRAME, channel={"P9": "P1"}),
        lambda: hydrofdi.measure(FRAME, channel="P17"),
        lambda: hydrofdi.measure({"a": [1.0, 2.0], "b": [1.0, 2.0]}),
        lambda: hydrofdi.measure(FRAME.rename(columns={"time [s]": "t"})),
        lambda: hydrofdi.measure(FRAME.rename(columns={"P1 [bar]": "P1"})),
        lambda: hydrofdi.measure(["a", 1]),
        lambda: hydrofdi.measure(np.zeros((2, 2, 2))),
        lambda: hydrofdi.measure(np.zeros((0, 2)), **RATE),
        lambda: hydrofdi.measure({"P1": np.zeros((2, 9)), "P2": np.zeros((3, 9))}, **RATE),
        lambda: hydrofdi.measure(NOISE, "dwtt", **RATE),
        lambda: hydrofdi.measure("nowhere.csv"),
        lambda: hydrofdi.measure("nowhere.csv", unit="bar"),
        lambda: hydrofdi.measure(pandas.DataFrame()),
        lambda: hydrofdi.measure([FRAME, pandas.DataFrame({"torque [N·m]": [1.0, 2.0]})]),
        *(lambda unit=unit: hydrofdi.measure(dataset(unit)) for unit in ("", "kg", "Bar", 5)),
        lambda: hydrofdi.measure(NOISE, unit="kg", **RATE),
        lambda: hydrofdi.train(NOISE, output="d2", direction="both", window="2 bar", **RATE),
        lambda: hydrofdi.train(NOISE, config={"window": 2}, **RATE),
        lambda: hydrofdi.inspect(NOISE, record="x", **RATE),
        lambda: hydrofdi.sweep(STUDY, engine="foo"),
        lambda: hydrofdi.sweep(STUDY, workers=1.5),
        lambda: hydrofdi.plan(STUDY, workers=0),
        lambda: hydrofdi.plan(STUDY, workers="x"),
        lambda: hydrofdi.sweep(STUDY, progress=5),
        lambda: hydrofdi.schema("foo"),
        lambda: hydrofdi.measure(NOISE, sampling_frequency=True),
        lambda: hydrofdi.measure(NOISE, sampling_frequency=[1]),
        lambda: hydrofdi.measure(NOISE, channel=5, **RATE),
        lambda: hydrofdi.measure(NOISE, unit=5, **RATE),
        lambda: hydrofdi.measure(NOISE, label=5, **RATE),
        lambda: hydrofdi.measure(NOISE, group=5, **RATE),
        lambda: hydrofdi.inspect(NOISE, record=5, **RATE),
        lambda: hydrofdi.replay(NOISE, rate=[1], **RATE),
        lambda: hydrofdi.evaluate(NOISE, healthy=1.5, label="a", **RATE),
        lambda: hydrofdi.evaluate(NOISE, false_alarm_rate=None, label="a", **RATE),
        lambda: hydrofdi.calibrate(flows=None),
        lambda: hydrofdi.indicators(5),
        lambda: hydrofdi.check(tolerance="x"),
        lambda: hydrofdi.plan(None),
        lambda: hydrofdi.sweep(None),
        lambda: hydrofdi.export(NOISE, "out", channels="", **RATE),
        lambda: hydrofdi.export(NOISE, "out", runs=[], **RATE),
        lambda: hydrofdi.export(NOISE, "out", unit="bar,psi", **RATE),
        lambda: hydrofdi.simulate(levels=4.5),
        lambda: hydrofdi.simulate(supply_pressure="16 MPa"),
    ],
)
def test_a_wrong_call_is_refused_in_one_sentence(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        call()
    assert len(str(refused.value).splitlines()) == 1
    assert not [*tmp_path.iterdir()]


def test_a_column_that_is_missing_is_a_key_error_as_well():
    with pytest.raises(KeyError):
        hydrofdi.measure(FRAME)["none"]


@pytest.mark.parametrize("several", [False, True])
def test_masked_samples_are_missing(several):
    wild = NOISE[:2].copy()
    wild[:, 100:400] = 1e9
    masked = np.ma.masked_greater(wild, 1e8)
    missing = np.where(wild > 1e8, np.nan, wild)
    given = [masked[0], masked[1]] if several else masked
    found, expected = (hydrofdi.measure(each, **RATE) for each in (given, missing))
    assert found["status"].tolist() == expected["status"].tolist()
    np.testing.assert_array_equal(found["dwt.d1"], expected["dwt.d1"])


def test_a_missing_label_is_no_kind_of_fault():
    label = ["sound"] * 100 + ["leaking"] * 60 + [None] * 20 + [float("nan")] * 20
    found = hydrofdi.evaluate(NOISE, label=label, healthy="sound", false_alarm_rate="5 %", **RATE)
    assert not {"nan", "None"} & set(found.table["population"])
    assert found.left.n_unlabelled == 40
    assert "without a label, left out: 40 of 200 records" in repr(found)


def test_labels_may_be_numbers():
    found = hydrofdi.evaluate(NOISE, label=[0] * 100 + [1] * 100, healthy=0, false_alarm_rate="5 %", **RATE)
    assert "1" in found.table["population"].tolist()


def test_results_stand_for_their_folder(tmp_path):
    stored = hydrofdi.sweep(STUDY, out=tmp_path / "asked", engine="in-process")
    assert hydrofdi.why(stored, np.int64(0)) == hydrofdi.why(stored.folder, 0)
    assert len(hydrofdi.export(stored, tmp_path / "out", runs=np.int64(0)).files) == 1
