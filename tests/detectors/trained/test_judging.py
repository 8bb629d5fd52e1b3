"""Windows are judged alike, alone or among others, and what forbids to judge is said in numbers."""

import numpy as np
import pytest

from hydrofdi.detectors.registry import make_chart
from hydrofdi.detectors.trained.configuration import ChartConfig, DetectorConfig
from hydrofdi.detectors.trained.file import ChartLimit, Made
from hydrofdi.detectors.trained.following import ScoreChart
from hydrofdi.detectors.trained.measuring import Judge, Verdict, channel_facts, learned_range
from hydrofdi.detectors.trained.training import train
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.indicators import indicator_names
from hydrofdi.records import Channel
from tests.detectors.trained.healthy import Records
from tests.detectors.trained.made import FREQUENCY, detector, signals, window
from tests.records.streams.plain import make_windower, windows_of

HEALTHY = [window(number, seed) for number, seed in enumerate(range(20))]
P1 = Channel.CHAMBER_1_PRESSURE


def judged(file, *windows):
    return Judge(file).judge(windows)


@pytest.mark.parametrize("name", indicator_names())
def test_a_window_is_judged_alike_alone_and_among_others(name):
    try:
        file = detector(name, direction="both", ranges=HEALTHY[:5])
    except ConfigError as refusal:
        pytest.skip(str(refusal))
    judge = Judge(file)
    windows = [*HEALTHY[:5], window(5, fault=Issue("is missing", kind="missing"))]
    together = judge.judge(windows)
    assert together == [judge.judge([each])[0] for each in windows]
    assert judge.judge(windows[::-1]) == together[::-1]
    assert judge.judge([]) == []


def test_scores_beyond_a_limit_are_alarms_and_those_on_it_are_not():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    (verdict,) = judged(detector(limits=(None, score), scale=(0.0, 2.0)), HEALTHY[0])
    assert (verdict.alarm, verdict.margin) == (False, 0.0)
    (verdict,) = judged(detector(limits=(None, score - 6.0), scale=(0.0, 2.0)), HEALTHY[0])
    assert verdict.alarm
    assert verdict.margin == pytest.approx(-3.0)
    (verdict,) = judged(detector(limits=(score - 6.0, score + 2.0), scale=(0.0, 2.0)), HEALTHY[0])
    assert not verdict.alarm
    assert verdict.margin == pytest.approx(1.0)
    (verdict,) = judged(detector(limits=(score + 4.0, None), scale=(0.0, 2.0)), HEALTHY[0])
    assert verdict.alarm
    assert verdict.margin == pytest.approx(-2.0)


def fault_of(*windows, **more):
    (verdict,) = judged(detector(ranges=HEALTHY, **more), *windows)
    assert verdict.alarm is None
    assert (verdict.score is None) == (verdict.margin is None) == (verdict.fault.kind != "novel")
    return verdict.fault


def test_faults_of_the_window_come_first():
    stated = Issue("came at 500 Hz instead of 1000 Hz", kind="other_rate")
    assert fault_of(window(n_sample=10, fault=stated, chamber_1_pressure=None)) is stated


@pytest.mark.parametrize(("limit", "is_beyond"), [(-1e9, True), (1e9, False)])
def test_a_novel_window_says_whether_its_score_is_beyond_the_limit(limit, is_beyond):
    novel = window(chamber_1_pressure=HEALTHY[0].channels[P1] + 20e6)
    (verdict,) = judged(detector(ranges=HEALTHY, limits=(None, limit)), novel)
    assert (verdict.alarm, verdict.is_beyond) == (None, is_beyond)


def test_other_windows_of_the_same_kind_are_not_novel():
    verdicts = judged(detector(ranges=HEALTHY), *(window(0, 1000 + seed) for seed in range(200)))
    assert all(verdict.fault is None for verdict in verdicts)


def test_a_score_far_out_on_the_side_without_an_alarm_is_novel():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    spread = 1e-3 * abs(score)
    for sign in (-1.0, 1.0):
        # Healthy scores reach five spreads from the median, so scores are novel from twenty spreads on.
        for place, is_novel in ((-4.0, False), (-2.0, False), (19.9, False), (20.1, True), (1e3, True)):
            centre = score - sign * place * spread
            limit = centre - sign * 3.0 * spread
            file = detector(
                limits=(None, limit) if sign < 0.0 else (limit, None),
                scale=(centre, spread),
                scores=(centre - 5.0 * spread, centre + 5.0 * spread),
            )
            (verdict,) = judged(file, HEALTHY[0])
            assert verdict.score == score
            if is_novel:
                assert (verdict.alarm, verdict.is_beyond, verdict.fault.kind) == (None, False, "novel")
            else:
                assert (verdict.alarm, verdict.fault) == (place < -3.0, None)


def test_with_limits_on_both_sides_no_score_is_far_out_without_an_alarm():
    (score,) = (verdict.score for verdict in judged(detector(), HEALTHY[0]))
    middle = score + 9e5
    file = detector(limits=(score - 1e3, score + 1e6), scale=(middle, 1.0), scores=(middle - 1, middle + 1))
    (verdict,) = judged(file, HEALTHY[0])
    assert (verdict.alarm, verdict.fault) == (False, None)


@pytest.mark.parametrize(
    ("kind", "changed"),
    [
        ("clipped", {"chamber_1_pressure": np.minimum(HEALTHY[0].channels[P1], 10e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1] + 20e6}),
        ("novel", {"chamber_1_pressure": 9e6 + 1e-3 * (HEALTHY[0].channels[P1] - 9e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1]
                   + 2e5 * np.random.default_rng(1).standard_normal(1000)}),
    ],
)  # fmt: skip
def test_what_forbids_to_judge_has_its_kind_and_is_no_alarm(kind, changed):
    assert fault_of(window(**changed), limits=(None, -1e9)).kind == kind


PS = Channel.SUPPLY_PRESSURE
CHANNELS = tuple(sorted({PS, *detector("flow_balance", direction="both").channels}))


def windows(seed, is_constant):
    samples = signals(seed, 5000)
    if is_constant:
        samples[PS] = np.full(5000, 17e6)
    windower = make_windower("time", 1000, channels=CHANNELS, sampling_frequency=FREQUENCY)
    return windows_of(np.arange(5000) / FREQUENCY, samples, windower)


def trained(is_constant):
    healthy = windows(1, is_constant)
    ranges = {
        each: learned_range(each, channel_facts(np.stack([w.channels[each] for w in healthy])))
        for each in CHANNELS
    }
    more = {"channels": CHANNELS, "ranges": ranges}
    return Judge(detector("flow_balance", direction="both").model_copy(update=more))


@pytest.mark.parametrize(("was_constant", "is_constant"), [(True, True), (False, False)])
def test_it_is_judged_where_healthy_windows_were_alike(was_constant, is_constant):
    faults = [verdict.fault for verdict in trained(was_constant).judge(windows(2, is_constant))]
    assert not [fault for fault in faults if fault is not None and fault.kind != "no_number"]


def test_it_is_stuck_where_healthy_windows_changed():
    (fault,) = {verdict.fault for verdict in trained(False).judge(windows(2, True))}
    assert (fault.kind, fault.message) == (
        "stuck",
        "supply_pressure is constant, but varies in healthy windows",
    )


SCORES = 10.0 + 2.0 * np.random.default_rng(5).standard_normal(60) + np.repeat([0.0, 3.0], 30)
OPTIONS = {"direction": "rising"}


def charted(direction="rising", limit=6.0, name="cusum"):
    bound = {"rising": (None, 1e9), "falling": (-1e9, None)}[direction]
    file = detector(limits=bound, scale=(10.0, 2.0), direction=direction)
    chart = ChartConfig(chart=name, options=OPTIONS)
    limits = ChartLimit(limit=limit, mean_time=None, interval=(0.0, None), hours=1.0)
    config = file.config.model_copy(update={"chart": chart})
    return file.model_copy(update={"config": config, "chart": limits})


def readings(chart, verdicts):
    state, found = chart.start(), []
    for verdict in verdicts:
        state, reading = chart.step(state, verdict)
        found.append(reading)
    return found


def judged_charting(scores):
    return [Verdict(score, False, 1.0) for score in scores.tolist()]


@pytest.mark.parametrize(("direction", "scores"), [("rising", SCORES), ("falling", 20.0 - SCORES)])
def test_it_is_the_chart_of_standardised_scores(direction, scores):
    found = readings(ScoreChart(charted(direction)), judged_charting(scores))
    expected = make_chart("cusum", OPTIONS).follow((SCORES - 10.0)[None] / 2.0, 6.0)[0]
    np.testing.assert_array_equal([reading.statistic for reading in found], expected)
    assert [reading.alarm for reading in found] == (expected >= 6.0).tolist()
    assert any(reading.alarm for reading in found[30:])
    assert not any(reading.alarm for reading in found[:30])


def test_what_is_not_judged_passes_it_by():
    novel = Verdict(1e6, None, None, Issue("is novel", kind="novel"))
    lost = Verdict(None, None, None, Issue("is missing", kind="missing"))
    mixed = [each for verdict in judged_charting(SCORES) for each in (novel, verdict, lost)]
    found = readings(ScoreChart(charted()), mixed)
    assert found[1::3] == readings(ScoreChart(charted()), judged_charting(SCORES))
    assert all(reading.statistic is None and not reading.alarm for reading in found[::3] + found[2::3])


def test_healthy_records_of_a_day_set_up_a_chart_unless_none_is_wanted():
    means = np.random.default_rng(5).standard_normal((20, 5))
    number = {"indicator": "pressure_statistics", "output": "mean", "direction": "both"}
    for frequency, given, has_chart in ((0.004, {}, True), (0.004, {"chart": None}, False), (4.0, {}, False)):
        window = {"window": {"duration": 4.0 / frequency}}
        config = DetectorConfig.model_validate({**number, **window, "false_alarm_rate": 0.1, **given})
        records = Records(means, sampling_frequency=frequency)
        file = train(records, config, ["records"], Made(hydrofdi="1", time="now"))
        assert (file.chart is not None) is has_chart
        assert file.config.chart is None or file.config.chart.false_alarm_every == 86400.0
