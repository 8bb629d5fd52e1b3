"""Wrong calls of methods and sections, answered in one sentence."""

import numpy
import pytest

import hydrofdi


@pytest.fixture(scope="module")
def simulated():
    return hydrofdi.simulate(duration="2 s")


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda each: each.plot("P1"), "plot: accepts no argument by position"),
        (lambda each: each.write(), "write: give path"),
        (lambda each: each.write("r.csv"), r"ends in \.h5"),
    ],
)
def test_a_wrong_call_of_a_run(simulated, call, sentence):
    with pytest.raises(hydrofdi.HydrofdiError, match=sentence):
        call(simulated)


def test_a_wrong_call_of_results(small_sweep):
    found = hydrofdi.results(small_sweep.directory)
    with pytest.raises(hydrofdi.HydrofdiError, match="unknown argument 'format'; it takes no arguments"):
        found.report(format="csv")
    with pytest.raises(hydrofdi.HydrofdiError, match="plot: accepts only figure by position"):
        found.plot("responses", "big")


@pytest.mark.parametrize("keyword", ["supply_pressure", "fluid_bulk_modulus"])
def test_one_underscore_between_section_and_key_is_answered_with_two(keyword):
    wanted = keyword.replace("_", "__", 1)
    with pytest.raises(hydrofdi.HydrofdiError, match=f"did you mean '{wanted}'"):
        hydrofdi.simulate(**{keyword: "16 MPa"})


@pytest.fixture(scope="module")
def healthy():
    return 5e6 + 1e4 * numpy.random.default_rng(1).standard_normal((100, 1000))


def test_a_wrong_call_of_a_detector(healthy, tmp_path):
    detector = hydrofdi.train(
        healthy, output="d2", direction="rising", sampling_frequency="1 kHz", false_alarm_rate="2 %"
    )
    with pytest.raises(hydrofdi.HydrofdiError, match="judge: unknown argument 'sampling_rate'; did you mean"):
        detector.judge(healthy, sampling_rate="1 kHz")
    with pytest.raises(hydrofdi.HydrofdiError, match="save: give path"):
        detector.save()
    with pytest.raises(hydrofdi.HydrofdiError, match="load: give path"):
        hydrofdi.Detector.load()
    detector.save(tmp_path / "d.json")
    assert repr(hydrofdi.Detector.load(path=tmp_path / "d.json")) == repr(detector)


def test_a_wrong_call_of_an_evaluation(healthy):
    label = ["sound"] * 60 + ["leaking"] * 40
    found = hydrofdi.evaluate(
        healthy, label=label, healthy="sound", sampling_frequency="1 kHz", false_alarm_rate="5 %"
    )
    with pytest.raises(hydrofdi.HydrofdiError, match="plot: unknown argument 'name'; known: figure"):
        found.plot(name="roc")
