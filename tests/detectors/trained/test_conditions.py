"""A detector says which conditions its healthy records cover; windows outside of them are novel."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.lines import line_record
from hydrofdi.detectors.rules import make_score
from hydrofdi.detectors.scores.contract import cross_fitted_scores
from hydrofdi.detectors.verdicts import Measured, coverage, outside, verdict_of
from hydrofdi.errors import Issue, NotStatedError
from hydrofdi.evaluation.scores import Direction
from tests.commands import run_hydrofdi
from tests.detectors.trained.test_training import MEAN, trained

STATED = {key: value for key, value in MEAN.items() if key != "window"} | {"sampling_frequency": 100}


def records(temperatures, level=85e5, seed=0):
    """A second of pressure and oil temperature [K] at 100 Hz for each temperature."""
    noise = np.random.default_rng(seed).standard_normal((len(temperatures), 100))
    oil = np.repeat(np.asarray(temperatures, dtype=float)[:, None], 100, axis=1)
    return {"chamber_1_pressure": level + 1e4 * noise, "oil_temperature": oil}


def test_windows_far_outside_of_the_covered_temperatures_are_novel_and_name_them():
    detector = hydrofdi.train(records(np.linspace(300.15, 320.15, 30)), **STATED)
    assert detector.file.conditions == {"oil_temperature": pytest.approx((300.15, 320.15))}
    assert "It covers oil temperature 27.0 °C to 47.0 °C." in detector.summary.splitlines()
    temperatures = [310.0, 321.0, 391.15, 230.0]
    made = records(temperatures, seed=1)
    told = detector.judge(made, sampling_frequency=100)
    assert told["fault"].tolist() == ["", "", "novel", "novel"]
    assert told["reason"][2] == "oil temperature is 118.0 °C; healthy windows cover 27.0 °C to 47.0 °C"
    lines = [line_record(window) for window in detector.windows(made, sampling_frequency=100)]
    assert [line["oil_temperature"] for line in lines] == pytest.approx(temperatures)
    told = detector.judge(records([310.0, 440.0], level=85.1e5), sampling_frequency=100)
    assert told["alarm"].tolist() == [True, None], "an alarm outside of them is not raised"
    del made["oil_temperature"]
    assert {*detector.judge(made, sampling_frequency=100)["reason"]} == {"has no oil_temperature"}


@pytest.mark.parametrize(("span", "is_narrow"), [(0.08, True), (0.12, False)])
def test_a_bulk_modulus_that_hardly_varies_is_narrow_and_few_windows_leave_more_room(span, is_narrow):
    covered = {"oil_temperature": (300.0, 320.0), "balance.bulk_modulus": (500e6, 500e6 * (1.0 + span))}
    assert ("balance.bulk_modulus hardly varies: other conditions" in coverage(covered)) is is_narrow
    assert "record warm" not in coverage(covered)
    assert outside(covered, 1000, {"oil_temperature": 325.0}) is not None
    assert outside(covered, 30, {"oil_temperature": 325.0}) is None
    assert outside({"oil_temperature": (310.0, 310.2)}, 30, {"oil_temperature": 325.0}) is not None
    del covered["oil_temperature"]
    assert "record warm" in coverage(covered)


@pytest.fixture(scope="module")
def plain():
    return trained(np.random.default_rng(0).standard_normal((100, 1)))


def test_of_an_estimate_outside_its_range_an_alarm_stays_and_other_windows_are_novel(plain):
    file, high = plain.model_copy(update={"conditions": {"b.bulk_modulus": (5e8, 6e8)}}), plain.limits.high
    for score, is_alarm in ((high + 1.0, True), (high - 1.0, None)):
        found = verdict_of(file, score, Measured(np.array([score]), conditions={"b.bulk_modulus": 900e6}))
        assert found.alarm is is_alarm
        assert "b.bulk_modulus is 900 MPa" in (found.doubt or found.fault.message)
    within = Measured(np.array([high + 1.0]), conditions={"b.bulk_modulus": 550e6})
    assert verdict_of(file, high + 1.0, within).doubt == ""


@pytest.mark.parametrize(
    ("above", "kinds", "doubt"),
    [
        (1.0, ("misfit", "incompressible"), ""), (1.0, ("misfit", "unexplained"), "unexplained"),
        (-1.0, ("misfit",), "misfit"), (1.0, ("misfit", "impossible"), "impossible"),
    ],
)  # fmt: skip
def test_what_a_leak_explains_does_not_make_an_alarm_doubtful(plain, above, kinds, doubt):
    score = plain.limits.high + above
    doubts = tuple(Issue(kind, "b" if kind == "impossible" else "b.misfit", kind=kind) for kind in kinds)
    assert verdict_of(plain, score, Measured(np.array([score]), doubts=doubts)).doubt == doubt


def test_the_estimates_and_the_temperature_are_covered_and_unknown_oil_raises_the_limit(tmp_path):
    run_hydrofdi("simulate", "--out", "sound.h5", "--set", "record.duration=24 s",
                 "--set", "pressure_1_sensor.noise=20 kPa", "--set", "leakage.internal_flow=50 mL/min",
                 cwd=tmp_path)  # fmt: skip
    chunks = [*hydrofdi.replay(tmp_path / "sound.h5", rate="max")]
    time = np.concatenate([chunk.time for chunk in chunks])
    channels = {
        name: np.concatenate([chunk.channels[name] for chunk in chunks])
        for name in ("chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage")
    }
    oil = {"oil_temperature": np.full(time.size, 310.0)}
    frequency = round(1.0 / (time[1] - time[0]))
    config = {"indicator": "weak_rls", "options": {"spool": "command", "supply": "sum"},
              "window": {"duration": 2.5}, "false_alarm_rate": 0.2}  # fmt: skip

    def train(channels, **more):
        return hydrofdi.train(channels, config=config | more, sampling_frequency=frequency)

    detector = train(channels | oil)
    estimates = {"weak_rls.bulk_modulus", "weak_rls.supply_pressure"}
    assert set(detector.file.conditions) == {"oil_temperature", *estimates}
    *_, last = detector.windows(channels | oil, sampling_frequency=frequency)
    assert last.verdict.temperature == pytest.approx(310.0)
    assert "Warning: weak_rls: not given" in detector.summary  # the temperature assumes no actuator
    hot = channels | {"oil_temperature": np.full(time.size, 350.0)}
    assert set(detector.judge(hot, sampling_frequency=frequency)["fault"]) == {"novel"}
    allowing, exact = train(channels).file.limits, train(channels, compensate=False).file
    assert 0.0 < allowing.allowance < 0.6 * exact.healthy.centre
    assert allowing.high == pytest.approx(exact.limits.high + allowing.allowance)
    assert exact.limits.allowance == detector.file.limits.allowance == 0.0
    with pytest.raises(NotStatedError, match=r"no healthy record has weak_rls\.leakage"):
        train(channels | oil, window={"duration": 0.2})


def warming(n, seed, leak=0.0):
    """Records whose mean pressure rises by 10 kPa/K, and by noise of 1 kPa, over 20 K."""
    temperatures = np.random.default_rng(seed).uniform(300.0, 320.0, n)
    made = records(temperatures, seed=seed)
    made["chamber_1_pressure"] += 1e4 * (temperatures - 300.0)[:, None] + leak
    return made


def alarm_share(detector, data):
    return np.mean([bool(alarm) for alarm in detector.judge(data, sampling_frequency=100)["alarm"]])


def test_the_effect_of_the_temperature_is_taken_out_by_default_and_the_rate_is_kept():
    detectors = [hydrofdi.train(warming(200, 10 + n), **STATED) for n in range(3)]
    plain = hydrofdi.train(warming(200, 10), compensate=False, **STATED)
    assert detectors[0].file.config.score.kind == "either"
    assert plain.file.config.score is None
    assert alarm_share(detectors[0], warming(400, 2, 1e4)) > 0.99
    assert alarm_share(plain, warming(400, 2, 1e4)) < 0.5
    shares = [alarm_share(each, warming(500, 100 + n)) for n, each in enumerate(detectors)]
    deviation = np.sqrt(0.05 * 0.95 * (1.0 / 200.0 + 1.0 / 500.0) / 3.0)
    assert np.mean(shares) == pytest.approx(10 / 201, abs=3.0 * deviation)


def test_a_temperature_that_is_always_the_same_and_windows_without_a_number_are_no_obstacle():
    one, plain = (
        hydrofdi.train(records([300.0] * 30), compensate=compensate, **STATED).file
        for compensate in (True, False)
    )
    assert not one.basis.not_judged
    room = plain.limits.high - plain.healthy.centre
    assert one.limits.high - one.healthy.centre == pytest.approx(room, rel=0.2)
    healthy = warming(100, 0)
    healthy["chamber_1_pressure"][:30, 5] = np.nan
    basis = hydrofdi.train(healthy, window="0.5 s", **STATED).file.basis
    assert (basis.n_window, basis.not_judged) == (170, {"missing": 30})


def leaky(seed, temperatures, leak=0.0):
    """Outputs of a balance on a leaky valve, of whose clearances K_i takes up a share [L/min]."""
    machine, draw = np.random.default_rng([seed, 0]), np.random.default_rng([seed, len(temperatures)])
    clearance, share, noise = machine.uniform([0.02, 0.0, 1e-3], [0.3, 0.64, 4e-3])
    through = clearance * machine.uniform(1.02, 1.04) ** (temperatures - 310.0)
    errors = noise * draw.standard_normal((2, temperatures.size))
    return np.stack([share * through + leak + errors[0], through + leak + errors[1], temperatures], axis=1)


def outcomes(seed, n_healthy=60, n_test=25):
    """Alarms 15 K above all healthy windows, without a leak and with 0.2 L/min, and how wide the limit is."""
    inside = np.random.default_rng([seed, 1]).uniform(300.0, 320.0, n_healthy)
    score, healthy, fit = make_score("either", {"proxies": 1}), leaky(seed, inside), np.zeros(n_healthy, bool)
    scores = cross_fitted_scores(score, healthy, fit)
    high = DetectorConfig(false_alarm_rate=0.02).set_threshold(scores, Direction.RISING).high
    fitted, warm = score.fit(healthy, fit), np.full(n_test, 335.0)
    tests = [fitted.score(leaky(seed, warm, leak)) > high for leak in (0.0, 0.2)]
    return np.mean(tests, axis=1), float(fitted.widening(leaky(seed, warm))[0])


def test_beyond_the_oil_temperatures_of_the_training_the_rate_is_kept_and_leaks_are_found():
    found = [outcomes(seed) for seed in range(100)]
    false, detected = np.mean([shares for shares, _ in found], axis=0)
    assert false <= 0.02
    assert detected >= 0.9
    assert max(widening for _, widening in found) < 10.0
