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


NOT_MEASURED = [
    (FRAME, RATE), (WORDS, {}), (NOISE, {}), (FRAME, {"channel": {"P9": "P1"}}), (FRAME, {"channel": "P17"}),
    ({"a": [1.0, 2.0], "b": [1.0, 2.0]}, {}), (FRAME.rename(columns={"time [s]": "t"}), {}),
    (FRAME.rename(columns={"P1 [bar]": "P1"}), {}), (["a", 1], {}), (np.zeros((2, 2, 2)), {}),
    (np.zeros((0, 2)), RATE), (NOISE[:1].T, RATE), ({"P1": np.zeros((2, 9)), "P2": np.zeros((3, 9))}, RATE),
    ({"piston position [mm]": NOISE[0], "u [V]": NOISE[0]}, {"indicators": "dwt", **RATE}),
    *((NOISE, {"sampling_frequency": wrong}) for wrong in ("1 kHZ", 0, True, [1])),
    *((NOISE, RATE | {key: 5}) for key in ("channel", "unit", "label", "group")),
    (NOISE, RATE | {"unit": "kg"}), (NOISE, RATE | {"indicators": "dwtt"}), ("nowhere.csv", {}),
    ("nowhere.csv", {"unit": "bar"}), (pandas.DataFrame(), {}),
    ([FRAME, pandas.DataFrame({"torque [N·m]": [1.0, 2.0]})], {}),
    *((dataset(unit), {}) for unit in ("", "Bar", 5)),
]  # fmt: skip
CALLS = [
    "calibrate()", "calibrate(flows=None)", "load_experiment({'name': 'x'}, 5)", "sweep(FRAME)", "plan(None)",
    "sweep(STUDY, engine='foo')", "sweep(STUDY, workers=1.5)", "sweep(STUDY, progress=5)", "sweep(None)",
    "plan(STUDY, workers=0)", "plan(STUDY, workers='x')", "indicators(5)", "schema('foo')",
    "simulate(levels=4.5)", "simulate(supply_pressure='16 MPa')",
    "train(NOISE, output='d2', direction='both', window='2 bar', **RATE)",
    "train(NOISE, config={'window': 2}, **RATE)", "inspect(NOISE, record='x', **RATE)",
    "inspect(NOISE, record=5, **RATE)", "replay(NOISE, rate=[1], **RATE)",
    "evaluate(NOISE, healthy=1.5, label='a', **RATE)", "export(NOISE, 'out', channels='', **RATE)",
    "evaluate(NOISE, false_alarm_rate=None, label='a', **RATE)", "export(NOISE, 'out', runs=[], **RATE)",
    "export(NOISE, 'out', unit='bar,psi', **RATE)",
]  # fmt: skip


@pytest.mark.parametrize("call", [*NOT_MEASURED, *CALLS])
def test_a_wrong_call_is_refused_in_one_sentence_and_writes_nothing(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(hydrofdi.HydrofdiError) as refused:
        eval(f"hydrofdi.{call}") if isinstance(call, str) else hydrofdi.measure(call[0], **call[1])
    assert len(str(refused.value).splitlines()) == 1
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


def test_results_stand_for_their_folder(tmp_path):
    stored = hydrofdi.sweep(STUDY, out=tmp_path / "asked", engine="in-process")
    assert hydrofdi.why(stored, np.int64(0)) == hydrofdi.why(stored.folder, 0)
    assert len(hydrofdi.export(stored, tmp_path / "out", runs=np.int64(0)).files) == 1


WORK = [
    "run.plot()", "run.features['dwt.d2']", "run.signals['P1']", "run['P1']", "run.t",
    "run.chamber_1_pressure", "run['dwt.d2']", "run.save('again.h5')", "hydrofdi.measure('run.h5')",
    "hydrofdi.load_experiment(settings='bulk_modulus=689 MPa')",
    "hydrofdi.load_experiment(None, {'pressure_1_sensor__noise': 2.0})",
    "hydrofdi.load_experiment({'EBM': '689 MPa', 'fluid': {'law': 'free_air'}}, {'m': '250 kg'})",
]  # fmt: skip
ANSWERED = {
    "run.p1": "p1", "run['p1']": "'P1'", "hydrofdi.simulat": "simulat",
    "hydrofdi.Detector('detector.json')": "Detector.load",
    "hydrofdi.simulate(leakage='0.5 L/min')": "internal_flow",
    "hydrofdi.simulate(ki=1e-9)": "'K_i'", "hydrofdi.simulate(bulk=1e9)": "bulk_modulus'",
    "hydrofdi.simulate(leak='0.5 L/min')": "internal_flow'", "hydrofdi.simulate(noise=1)": "_sensor.noise",
}  # fmt: skip


def test_a_guess_works_or_is_answered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = hydrofdi.simulate(duration="2 s", out="run.h5")
    names = {"run": run, "hydrofdi": hydrofdi}
    for guess in WORK:
        eval(guess, names)
    for guess, answer in ANSWERED.items():
        with pytest.raises((AttributeError, hydrofdi.HydrofdiError), match=answer):
            eval(guess, names)
    assert run.P1.shape == run.time.shape == (1000,)
    assert np.isclose(run.mean_internal_leakage_flow.to("L/min"), run.mean_internal_leakage_flow * 60e3)
    with pytest.raises(ValueError, match="dimension"):
        run.mean_internal_leakage_flow.to("bar")
