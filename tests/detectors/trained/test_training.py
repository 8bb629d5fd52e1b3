"""Detectors are trained on windows that do not overlap, and say how far their promise carries."""

import json
from functools import partial
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import hydrofdi
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.errors import ConfigError, NotStatedError
from hydrofdi.evaluation.rates import alarm_rate, left_out_outcomes
from hydrofdi.evaluation.scores import Direction
from hydrofdi.evaluation.threshold import quantile_threshold
from hydrofdi.records import Channel
from hydrofdi.records.streams import Window
from tests.detectors.trained.healthy import PATTERN, Records, autoregressive, grouped

MEAN = {
    "indicator": "pressure_statistics",
    "output": "mean",
    "direction": "rising",
    "false_alarm_rate": 0.05,
    "window": {"duration": 1.0},
}
REPEATS = 100


def trained(means, groups=(), labels=None, more=(), **config):
    records = Records(means, groups, labels, **dict(more))
    return Detector.fit(records, DetectorConfig.model_validate(MEAN | config)).file


def normal(*shape, seed=0):
    return np.random.default_rng(seed).standard_normal(shape)


@pytest.mark.parametrize(
    ("draw_means", "n_group"),
    [
        (partial(autoregressive, shape=(100, 1), correlation=0.0), 0),
        (partial(autoregressive, shape=(40, 10), correlation=0.5), 0),
        (partial(grouped, n_group=10, n_window=40, correlation=0.2), 10),
    ],
    ids=["independent", "within records", "within groups"],
)
def test_the_interval_holds_the_rate_of_new_windows_also_where_windows_depend_on_each_other(
    draw_means, n_group
):
    rates, held = [], 0
    for seed in range(REPEATS):
        means = draw_means(np.random.default_rng(seed))
        limits = trained(means, [f"unit {number}" for number in range(n_group)]).limits
        rates.append(norm.sf(limits.high))
        held += limits.interval[0] <= rates[-1] <= limits.interval[1]
    assert held / REPEATS > 0.95 - 3 * sqrt(0.95 * 0.05 / REPEATS)
    assert means.shape != (100, 1) or np.mean(rates) == pytest.approx(5 / 101, abs=0.005)


@pytest.mark.parametrize("direction", Direction)
def test_limits_are_those_of_the_scores_that_the_detector_gives_the_windows(direction):
    means = normal(40, 1)
    file = trained(means, direction=direction)
    windows = [
        Window(row, np.arange(4) / 4.0, {Channel.CHAMBER_1_PRESSURE: mean + PATTERN})
        for row, mean in enumerate(means)
    ]
    scores = [verdict.score for verdict in Detector(file).score(windows)]
    expected = quantile_threshold(scores, 0.05, direction=direction)
    assert file.limits.low == (None if direction is Direction.RISING else expected.low)
    assert file.limits.high == (None if direction is Direction.FALLING else expected.high)


def test_each_group_meets_the_limits_of_the_others():
    means, groups = normal(12, 20), [f"day {row // 3}" for row in range(12)]
    limits, names = trained(means, groups).limits, np.repeat(groups, 20)
    rule = partial(quantile_threshold, false_alarm_rate=0.05)
    rate = alarm_rate(left_out_outcomes(means.ravel(), names, rule), groups=names)
    assert (limits.interval_rests_on, limits.interval) == ("groups", (rate.low, rate.high))
    assert trained(means).limits.interval_rests_on == "records"
    assert trained(means.reshape(1, -1)).limits.interval_rests_on == "windows"
    assert trained(means.reshape(-1, 1)).limits.interval_rests_on == "windows"
    two, one = (trained(normal(*shape), false_alarm_rate=0.01).limits for shape in ((2, 60), (1, 120)))
    assert two.interval_rests_on == "windows", "too few are left without a record"
    assert two.interval == one.interval


def test_windows_that_set_limits_do_not_overlap_even_where_the_detector_slides():
    sliding = trained(normal(10, 12), window={"duration": 1.0, "every": 0.25})
    assert sliding.basis.n_window == 120
    assert sliding.limits == trained(normal(10, 12)).limits
    assert trained(normal(10, 12), window={"duration": 2.0, "every": 0.75}).basis.n_window == 50


@pytest.mark.parametrize(
    ("direction", "shift", "first", "is_named"),
    [("rising", 12.0, 0, True), ("rising", -12.0, 0, False), ("falling", -12.0, 0, True),
     ("both", -12.0, 0, True), ("rising", 3.0, 0, False), ("rising", 12.0, 5, False)],
)  # fmt: skip
def test_a_record_mostly_far_beyond_the_others_is_named(direction, shift, first, is_named):
    means = normal(20, 10)
    means[7, first:] += shift
    file = trained(means, direction=direction)
    assert file.basis.outlying == ({"made record 7": 10} if is_named else {})
    assert ("made record 7 (10 windows)" in hydrofdi.Detector(file).summary) is is_named


def test_too_few_windows_are_refused_with_the_number_that_is_needed():
    with pytest.raises(NotStatedError) as refusal:
        trained(normal(98, 1), false_alarm_rate=0.01)
    assert refusal.value.records_needed == 99
    trained(normal(99, 1), false_alarm_rate=0.01)
    for means, groups, more in (
        (normal(2, 60), ["day 1", "day 2"], {"false_alarm_rate": 0.01}),
        (normal(58, 1), (), {"threshold": "tolerance"}),
        ([], (), {}),
    ):
        with pytest.raises(NotStatedError):
            trained(means, groups, **more)


def test_windows_that_cannot_be_judged_teach_nothing_and_last_as_long_as_records_by_default():
    means = normal(30, 3)
    means[3, 2] = np.nan
    for window, n_window, fault in (({}, 29, "missing"), (MEAN["window"], 89, "missing_channel")):
        file = trained(means, window=window)
        assert file.basis.not_judged == {fault: 1}
        assert file.basis.n_window == n_window
        duration = window.get("duration", 3.0)
        assert (file.n_sample, file.config.window.duration) == (4 * duration, duration)
        assert file.config.window.every == duration


def charted(means, every=200.0):
    return trained(means, chart={"chart": "cusum", "false_alarm_every": every}).chart


def test_the_limit_of_a_chart_is_that_of_scores_in_their_order_turned_where_a_leak_lowers_them():
    drawn = autoregressive(np.random.default_rng(3), (20, 100), 0.9)
    in_order, shuffled = charted(drawn), charted(np.random.default_rng(4).permuted(drawn, axis=1))
    assert in_order.limit > 2.0 * shuffled.limit
    assert in_order.hours == pytest.approx(2000.0 / 3600.0)
    assert in_order.interval[0] < in_order.mean_time < in_order.interval[1]
    assert in_order.rests_on == "records"
    long = charted(normal(1, 2000))
    assert long.rests_on == "pieces"
    assert long.mean_time == pytest.approx(200.0, rel=0.2)
    chart = {"chart": "ewma", "false_alarm_every": 100.0}
    mirrored = trained(-normal(20, 100), direction="falling", chart=chart)
    straight = trained(normal(20, 100), chart=chart)
    assert mirrored.chart.limit == pytest.approx(straight.chart.limit)
    assert mirrored.config.chart.options["direction"] == "rising"


def test_with_a_chart_too_few_windows_for_the_threshold_are_no_obstacle():
    chart = {"chart": "cusum", "false_alarm_every": 10.0}
    means = normal(6, 10)
    file = trained(means, false_alarm_rate=0.001, chart=chart)
    assert (file.limits.high, file.limits.false_alarm_rate) == (file.healthy.range[1], 1 / 61)
    assert file.alarm_text == f"where their chart cusum reaches {file.chart.limit:.4g}"
    groups = [f"day {row}" for row in range(6)]
    both = trained(means, groups, false_alarm_rate=0.001, chart=chart, direction="both")
    assert (both.limits.low, both.limits.high) == both.healthy.range
    with pytest.raises(NotStatedError):
        trained(means, false_alarm_rate=0.001)


def test_cycles_begin_where_the_drive_crosses_the_middle_of_its_healthy_range():
    drive = np.tile([0.0, 0.0, 5.0, 5.0, 5.0, 5.0, 5.0, 0.0], 60)[None]
    more = {"channels": {Channel.INPUT_VOLTAGE: drive}}
    window = {"by": "cycle", "duration": 1.0}
    file = trained(normal(1, 120), more=more, window=window)
    assert file.drive == (0.0, 5.0)
    assert file.channels == (Channel.CHAMBER_1_PRESSURE, Channel.INPUT_VOLTAGE)
    assert file.basis.n_window == 60
    with pytest.raises(ConfigError, match="give the length of each cycle"):
        trained(normal(1, 120), more=more, window={"by": "cycle"})
    with pytest.raises(NotStatedError, match="input_voltage is missing in all healthy records"):
        trained(normal(1, 120), window=window)


CONFIGS = Path(__file__).parents[3] / "configs"
CLOSED = "motions/closed-loop.yaml"
LEAKS = {"faults": {"leakage.internal_flow": ["2 L/min"], "each": 10, "fit": 0, "severity": "level"}}


def population(folder, name, seed, n_record, motion=(CLOSED,), study=None, **more):
    """Machines at work of which nobody knows more than the data sheet."""
    healthy = {"population": {"seed": seed}, "healthy": {"fit": n_record, "test": 1, "shift": 1}}
    base = [str(CONFIGS / each) for each in ("populations/unknown-plant.yaml", *motion)]
    path = folder / f"{name}.yaml"
    record = {"extends": base, "record": {"duration": "4 s"}, "study": healthy | (study or {})}
    path.write_text(json.dumps(record | more), encoding="utf-8")
    return path


def of_machines(healthy):
    return hydrofdi.train(healthy, "flow_balance", window="2 s", false_alarm_rate="5 %")


def summary(detector, source):
    windows = detector.windows(source)
    return json.loads("".join(windows.json()))["summary"]


def test_other_healthy_machines_alarm_as_promised_and_leaks_are_found(tmp_path):
    detector = of_machines(population(tmp_path, "healthy", 3, 40))
    found = summary(detector, population(tmp_path, "others", 4, 40))
    (low, high), promised = found["alarm_share_interval"], detector.file.limits.interval
    assert found["n_judged"] > 70
    assert low <= promised[1]
    assert promised[0] <= high
    assert found["alarm_share"] < 0.15
    told = detector.judge(population(tmp_path, "leak", 5, 1, study=LEAKS))
    assert sum(cause.endswith("hole or score") for cause in told["cause"]) > 0.7 * sum(told["alarm"])
    found = summary(detector, tmp_path / "leak.yaml")
    assert found["alarm_share"] > 0.7
    assert "novel" not in found["not_judged"]
    found = summary(detector, population(tmp_path, "weak", 8, 5, supply={"pressure": "12 MPa"}))
    assert found["n_alarm"] == 0
    assert found["not_judged"].keys() == {"novel"}


@pytest.mark.long
def test_a_large_leak_is_an_alarm_and_not_novel_in_open_loop(tmp_path):
    detector = of_machines(population(tmp_path, "open", 3, 30, []))
    found = summary(detector, population(tmp_path, "large", 5, 1, [], LEAKS))
    assert "novel" not in found["not_judged"]
    assert found["alarm_share"] > 0.7
