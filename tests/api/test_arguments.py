"""Arguments of a wrong kind are refused by their names; missing samples and labels are missing."""

from __future__ import annotations

import numpy as np
import pytest

import hydrofdi

NOISE = 5e6 + 1e4 * np.random.default_rng(1).standard_normal((200, 500))
RATE = {"sampling_frequency": "1 kHz"}
STUDY = {
    "name": "asked",
    "record": {"duration": "2 s"},
    "sweep": {"grid": {"fluid.bulk_modulus": ["551 MPa"]}},
}

WRONG = {
    "engine": lambda: hydrofdi.sweep(STUDY, engine="foo"),
    "workers: expected": lambda: hydrofdi.sweep(STUDY, workers=1.5),
    "workers: must": lambda: hydrofdi.plan(STUDY, workers=0),
    "workers": lambda: hydrofdi.plan(STUDY, workers="x"),
    "progress": lambda: hydrofdi.sweep(STUDY, progress=5),
    "kind": lambda: hydrofdi.schema("foo"),
    "sampling_frequency": lambda: hydrofdi.measure(NOISE, sampling_frequency=True),
    "sampling_frequency: expected": lambda: hydrofdi.measure(NOISE, sampling_frequency=[1]),
    "channel": lambda: hydrofdi.measure(NOISE, channel=5, **RATE),
    "unit": lambda: hydrofdi.measure(NOISE, unit=5, **RATE),
    "label": lambda: hydrofdi.measure(NOISE, label=5, **RATE),
    "group": lambda: hydrofdi.measure(NOISE, group=5, **RATE),
    "record": lambda: hydrofdi.inspect(NOISE, record=5, **RATE),
    "rate": lambda: hydrofdi.replay(NOISE, rate=[1], **RATE),
    "healthy": lambda: hydrofdi.evaluate(NOISE, healthy=1.5, label="a", **RATE),
    "false_alarm_rate": lambda: hydrofdi.evaluate(NOISE, false_alarm_rate=None, label="a", **RATE),
    "flows": lambda: hydrofdi.calibrate(flows=None),
    "name": lambda: hydrofdi.indicators(5),
    "tolerance": lambda: hydrofdi.check(tolerance="x"),
    "states nothing: plan": lambda: hydrofdi.plan(None),
    "states nothing: sweep": lambda: hydrofdi.sweep(None),
    "channels: is empty": lambda: hydrofdi.export(NOISE, "out", channels="", **RATE),
    "runs: is empty": lambda: hydrofdi.export(NOISE, "out", runs=[], **RATE),
    "units bar and psi": lambda: hydrofdi.export(NOISE, "out", unit="bar,psi", **RATE),
}


@pytest.mark.parametrize("named", WRONG)
def test_an_argument_of_a_wrong_kind_is_refused_by_its_name(named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        WRONG[named]()
    sought = "states nothing" if named.startswith("states nothing") else named
    assert sought in str(refused.value)
    assert not [*tmp_path.iterdir()]


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
