"""A detector says which conditions its healthy records cover; windows outside of them are novel."""

import json

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
from tests.detectors.trained.test_training import trained
from tests.records.measuring import csv_of

MEAN = {
    "indicator": "pressure_statistics",
    "output": "mean",
    "direction": "rising",
    "false_alarm_rate": "5 %",
}


def records(temperatures, level=85e5, seed=0):
    """A second of pressure and oil temperature [K] at 100 Hz for each temperature."""
    noise = np.random.default_rng(seed).standard_normal((len(temperatures), 100))
    oil = np.repeat(np.asarray(temperatures, dtype=float)[:, None], 100, axis=1)
    return {"chamber_1_pressure": level + 1e4 * noise, "oil_temperature": oil}


def own(temperatures):
    return hydrofdi.train(records(temperatures), sampling_frequency=100, **MEAN)


def test_windows_far_outside_of_the_covered_temperatures_are_novel_and_name_them():
    detector = own(np.linspace(300.15, 320.15, 30))
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
def test_a_bulk_modulus_that_hardly_varies_is_narrow(span, is_narrow):
    covered = {"oil_temperature": (300.0, 320.0), "balance.bulk_modulus": (500e6, 500e6 * (1.0 + span))}
    assert ("balance.bulk_modulus hardly varies: other conditions" in coverage(covered)) is is_narrow
    assert "record warm" not in coverage(covered)
    del covered["oil_temperature"]
    assert "record warm" in coverage(covered)


def test_where_the_temperature_hardly_varied_all_others_are_novel():
    detector = own([310.0] * 15 + [310.2] * 15)
    told = detector.judge(records([310.1, 325.0]), sampling_frequency=100)
    assert told["fault"].tolist() == ["", "novel"]


def test_of_an_estimate_outside_its_range_an_alarm_stays_and_other_windows_are_novel():
    file = trained(np.random.default_rng(0).standard_normal((100, 1)))
    file = file.model_copy(update={"conditions": {"b.bulk_modulus": (500e6, 600e6)}})
    high = file.limits.high
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
def test_what_a_leak_explains_does_not_make_an_alarm_doubtful(above, kinds, doubt):
    file = trained(np.random.default_rng(0).standard_normal((100, 1)))
    score = file.limits.high + above
    doubts = tuple(Issue(kind, "b" if kind == "impossible" else "b.misfit", kind=kind) for kind in kinds)
    assert verdict_of(file, score, Measured(np.array([score]), doubts=doubts)).doubt == doubt


def test_few_windows_leave_more_room():
    covered = {"oil_temperature": (300.0, 320.0)}
    assert outside(covered, 1000, {"oil_temperature": 325.0}) is not None
    assert outside(covered, 30, {"oil_temperature": 325.0}) is None


def test_columns_in_degrees_celsius_are_read_by_files_and_streams(tmp_path):
    def write(name, temperature, n):
        time = np.arange(100 * n) / 100.0
        samples = 85.0 + 0.1 * np.random.default_rng(n).standard_normal(time.size)
        oil = "oil temperature [°C]", np.full(time.size, temperature)
        (tmp_path / name).write_text(csv_of(("time [s]", time), ("P1 [bar]", samples), oil), encoding="utf-8")

    write("healthy.csv", 40.0, 30)
    write("hot.csv", 80.0, 2)
    options = ["--indicator", "pressure_statistics", "--output", "mean", "--direction", "rising"]
    run_hydrofdi("train", "healthy.csv", *options, "--window", "1 s", "--false-alarm-rate", "5 %",
                 "--out", "d.json", cwd=tmp_path)  # fmt: skip
    stored = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    assert stored["conditions"] == {"oil_temperature": pytest.approx([313.15, 313.15])}
    done = run_hydrofdi("monitor", "d.json", "hot.csv", "--no-follow", cwd=tmp_path, check=None)
    assert "oil temperature is 80.0 °C" in done.stdout


def test_the_estimates_and_the_temperature_are_covered(tmp_path):
    run_hydrofdi("simulate", "--out", "sound.h5", "--set", "record.duration=24 s",
                 "--set", "pressure_1_sensor.noise=20 kPa", "--set", "leakage.internal_flow=50 mL/min",
                 cwd=tmp_path)  # fmt: skip
    table = run_hydrofdi("replay", "sound.h5", "--rate", "max", cwd=tmp_path).stdout.splitlines()
    columns = np.array([line.split(",") for line in table[1:]], dtype=float).T
    named = dict(zip((title.split(" [")[0] for title in table[0].split(",")), columns, strict=True))
    channels = {name: named[name] for name in ("P1", "P2", "x", "u")}
    channels["oil_temperature"] = np.full(columns.shape[1], 310.0)
    frequency = round(1.0 / np.diff(named["time"][:2]).item())
    config = {"indicator": "weak_rls", "options": {"spool": "command", "supply": "sum"},
              "window": {"duration": 2.5}, "false_alarm_rate": 0.2}  # fmt: skip
    detector = hydrofdi.train(channels, config=config, sampling_frequency=frequency)
    assert set(detector.file.conditions) == {
        "oil_temperature", "weak_rls.bulk_modulus", "weak_rls.supply_pressure",
    }  # fmt: skip
    *_, last = detector.windows(channels, sampling_frequency=frequency)
    assert last.verdict.temperature == pytest.approx(310.0)
    assert detector.file.limits.allowance == 0.0
    unknown = {name: samples for name, samples in channels.items() if name != "oil_temperature"}
    allowing = hydrofdi.train(unknown, config=config, sampling_frequency=frequency)
    exact = hydrofdi.train(unknown, config=config | {"compensate": False}, sampling_frequency=frequency)
    assert 0.0 < allowing.file.limits.allowance < 0.6 * allowing.file.healthy.centre
    assert allowing.file.limits.high == pytest.approx(exact.file.limits.high + allowing.file.limits.allowance)
    assert exact.file.limits.allowance == 0.0
    with pytest.raises(NotStatedError, match=r"no healthy record has weak_rls\.leakage"):
        hydrofdi.train(channels, config=config | {"window": {"duration": 0.2}}, sampling_frequency=frequency)
    summary = hydrofdi.train(channels, config=config, sampling_frequency=frequency).summary
    assert "Warning: weak_rls: not given" in summary  # the temperature assumes no actuator
    channels["oil_temperature"] = np.full(columns.shape[1], 350.0)
    told = detector.judge(channels, sampling_frequency=frequency)
    assert set(told["fault"]) == {"novel"}


def warming(n, seed):
    """Records whose mean pressure rises by 10 kPa/K, and by noise of 1 kPa, over 20 K."""
    draw = np.random.default_rng(seed)
    temperatures = draw.uniform(300.0, 320.0, n)
    made = records(temperatures, seed=seed)
    made["chamber_1_pressure"] += 1e4 * (temperatures - 300.0)[:, None]
    return made


def alarm_share(detector, data):
    return np.mean([bool(alarm) for alarm in detector.judge(data, sampling_frequency=100)["alarm"]])


def test_the_effect_of_the_temperature_is_taken_out_by_default(tmp_path):
    """A detector that compensates is read again."""
    leak = warming(400, 2)
    leak["chamber_1_pressure"] += 1e4
    detector, plain = (
        hydrofdi.train(warming(200, 0), sampling_frequency=100, **MEAN, **more)
        for more in ({"out": tmp_path / "d.json"}, {"compensate": False})
    )
    again, other = hydrofdi.Detector.load(tmp_path / "d.json"), warming(20, 1)
    told = [each.judge(other, sampling_frequency=100)["score"].tolist() for each in (detector, again)]
    assert told[0] == told[1]
    assert detector.file.config.score.kind == "either"
    assert plain.file.config.score is None
    assert alarm_share(detector, leak) > 0.99
    assert alarm_share(plain, leak) < 0.5


def test_a_compensated_score_keeps_its_false_alarm_rate():
    detectors = [hydrofdi.train(warming(200, 10 + n), sampling_frequency=100, **MEAN) for n in range(3)]
    shares = [alarm_share(each, warming(500, 100 + n)) for n, each in enumerate(detectors)]
    deviation = np.sqrt(0.05 * 0.95 * (1.0 / 200.0 + 1.0 / 500.0) / 3.0)
    assert np.mean(shares) == pytest.approx(10 / 201, abs=3.0 * deviation)


def test_of_a_temperature_that_is_always_the_same_nothing_is_taken_out_and_it_is_not_stuck():
    one = own([300.0] * 30)
    assert not one.file.basis.not_judged
    plain = hydrofdi.train(records([300.0] * 30), sampling_frequency=100, compensate=False, **MEAN)
    assert one.file.limits.high - one.file.healthy.centre == pytest.approx(
        plain.file.limits.high - plain.file.healthy.centre, rel=0.2
    )


def test_windows_without_a_number_are_no_obstacle_to_compensation():
    healthy = warming(100, 0)
    healthy["chamber_1_pressure"][:30, 5] = np.nan
    stated = {"window": "0.5 s", "sampling_frequency": 100}
    detector = hydrofdi.train(healthy, **stated, **MEAN)
    assert detector.file.basis.n_window == 170
    assert detector.file.basis.not_judged == {"missing": 30}


def leaky(seed, temperatures, leak=0.0):
    """Outputs of a balance on a leaky valve, of whose clearances K_i takes up a share [L/min]."""
    machine, draw = np.random.default_rng([seed, 0]), np.random.default_rng([seed, len(temperatures)])
    clearance, share, noise = (
        machine.uniform(0.02, 0.3),
        machine.uniform(0.0, 0.64),
        machine.uniform(1e-3, 4e-3),
    )
    through = clearance * machine.uniform(1.02, 1.04) ** (temperatures - 310.0)
    errors = noise * draw.standard_normal((2, temperatures.size))
    return np.stack([share * through + leak + errors[0], through + leak + errors[1], temperatures], axis=1)


def outcomes(seed, n_healthy=60, n_test=25):
    """Alarms 15 K above all healthy windows, without a leak and with 0.2 L/min, and how wide the limit is."""
    inside = np.random.default_rng([seed, 1]).uniform(300.0, 320.0, n_healthy)
    score, healthy = make_score("either", {"proxies": 1}), leaky(seed, inside)
    fit = np.zeros(n_healthy, dtype=bool)
    high = DetectorConfig(false_alarm_rate=0.02).set_threshold(
        cross_fitted_scores(score, healthy, fit), Direction.RISING
    ).high  # fmt: skip
    fitted, warm = score.fit(healthy, fit), np.full(n_test, 335.0)
    tests = [fitted.score(leaky(seed, warm, leak)) > high for leak in (0.0, 0.2)]
    return np.mean(tests, axis=1), float(fitted.rule.widening(leaky(seed, warm))[0])


def test_beyond_the_oil_temperatures_of_the_training_the_rate_is_kept_and_leaks_are_found():
    found = [outcomes(seed) for seed in range(100)]
    false, detected = np.mean([shares for shares, _ in found], axis=0)
    assert false <= 0.02
    assert detected >= 0.9
    assert max(widening for _, widening in found) < 10.0
