"""Windows are judged alike, alone or among others, and what forbids to judge is said in numbers."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import Made
from hydrofdi.detectors.rules import make_chart
from hydrofdi.detectors.training import train
from hydrofdi.detectors.verdicts import Verdict, channel_facts, findings, learned_range
from hydrofdi.errors import Issue
from hydrofdi.indicators import indicator_names
from hydrofdi.records import Channel, RecordBatch
from tests.detectors.trained.healthy import Records
from tests.detectors.trained.made import FREQUENCY, detector, pressure, signals, window, with_chart, written

HEALTHY = [window(number, seed) for number, seed in enumerate(range(20))]
P1 = Channel.CHAMBER_1_PRESSURE


def judged(file, *windows):
    return Detector(file).score(windows)


@pytest.mark.parametrize("name", indicator_names())
def test_a_window_is_judged_alike_alone_and_among_others(name):
    number = {"output": "coefficients[5]"} if name == "volterra" else {}  # its other outputs are arrays
    file = detector(name, direction="both", ranges=HEALTHY[:5], **number)
    trained = Detector(file)
    windows = [*HEALTHY[:5], window(5, fault=Issue("is missing", kind="missing"))]
    together = trained.score(windows)
    assert together == [trained.score([each])[0] for each in windows]
    assert trained.score(windows[::-1]) == together[::-1]
    assert trained.score([]) == []


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
        ("stuck", {"chamber_1_pressure": np.full(1000, 9e6)}),
        ("stuck", {"chamber_1_pressure": np.repeat(HEALTHY[0].channels[P1][::2], 2)}),
        ("clipped", {"chamber_1_pressure": np.minimum(HEALTHY[0].channels[P1], 10e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1] + 20e6}),
        ("novel", {"chamber_1_pressure": 9e6 + 1e-3 * (HEALTHY[0].channels[P1] - 9e6)}),
        ("novel", {"chamber_1_pressure": HEALTHY[0].channels[P1]
                   + 2e5 * np.random.default_rng(1).standard_normal(1000)}),
    ],
)  # fmt: skip
def test_what_forbids_to_judge_has_its_kind_and_is_no_alarm(kind, changed):
    assert fault_of(window(**changed), limits=(None, -1e9)).kind == kind


def test_a_channel_that_is_constant_in_healthy_windows_may_be():
    constant = {"chamber_1_pressure": np.full(1000, 9e6)}
    (verdict,) = judged(
        detector(ranges=[window(number, **constant) for number in range(5)]), window(**constant)
    )
    assert verdict.fault is None


SCORES = 10.0 + 2.0 * np.random.default_rng(5).standard_normal(60) + np.repeat([0.0, 3.0], 30)
OPTIONS = {"direction": "rising"}


def charted(direction="rising", limit=6.0):
    bound = {"rising": (None, 1e9), "falling": (-1e9, None)}[direction]
    file = detector(limits=bound, scale=(10.0, 2.0), direction=direction)
    return with_chart(file, limit=limit, **OPTIONS)


def readings(file, verdicts):
    detector, state, found = Detector(file), {"memory": np.zeros((1, 2))}, []
    for verdict in verdicts:
        state, reading = detector._reading(state, verdict)
        found.append(reading)
    return found


def judged_charting(scores):
    return [Verdict(score, False, 1.0) for score in scores.tolist()]


@pytest.mark.parametrize(("direction", "scores"), [("rising", SCORES), ("falling", 20.0 - SCORES)])
def test_it_is_the_chart_of_standardised_scores(direction, scores):
    found = readings(charted(direction), judged_charting(scores))
    expected = make_chart("cusum", OPTIONS).follow((SCORES - 10.0)[None] / 2.0, 6.0)[0]
    np.testing.assert_array_equal([reading.statistic for reading in found], expected)
    assert [reading.alarm for reading in found] == (expected >= 6.0).tolist()
    assert any(reading.alarm for reading in found[30:])
    assert not any(reading.alarm for reading in found[:30])


def test_what_is_not_judged_passes_it_by():
    novel = Verdict(1e6, None, None, Issue("is novel", kind="novel"))
    lost = Verdict(None, None, None, Issue("is missing", kind="missing"))
    mixed = [each for verdict in judged_charting(SCORES) for each in (novel, verdict, lost)]
    found = readings(charted(), mixed)
    assert found[1::3] == readings(charted(), judged_charting(SCORES))
    assert all(reading.statistic is None and not reading.alarm for reading in found[::3] + found[2::3])


def test_healthy_records_of_a_day_set_up_a_chart_unless_none_is_wanted():
    means = np.random.default_rng(5).standard_normal((20, 5))
    number = {"indicator": "pressure_statistics", "output": "mean", "direction": "both"}
    for frequency, stated, has_chart in (
        (0.004, {}, True),
        (0.004, {"chart": None}, False),
        (4.0, {}, False),
    ):
        window = {"window": {"duration": 4.0 / frequency}}
        config = DetectorConfig.model_validate({**number, **window, "false_alarm_rate": 0.1, **stated})
        records = Records(means, sampling_frequency=frequency)
        file = train(records, config, ["records"], Made(hydrofdi="1", time="now"))
        assert (file.chart is not None) is has_chart
        assert file.config.chart is None or file.config.chart.false_alarm_every == 86400.0


N_SAMPLE = 1000


def healthy_ranges(channels):
    """What ten seconds of such a stream teach, looked at second by second."""
    rows = signals(3, 10 * N_SAMPLE)
    return {each: learned_range(each, [channel_facts(rows[each].reshape(10, -1))]) for each in channels}


def held_samples(_, rows):
    samples = rows[Channel.CHAMBER_1_PRESSURE]
    samples[:] = samples[np.arange(samples.size) // 10 * 10]


def interpolated(time, rows):
    samples = rows[Channel.CHAMBER_1_PRESSURE]
    samples[:] = np.interp(time, time[::10], samples[::10])


@pytest.mark.parametrize("change", [held_samples, interpolated])
def test_the_true_rate_of_a_slow_channel_is_named(change):
    rows = {channel: samples.copy() for channel, samples in signals(3, N_SAMPLE).items()}
    change(np.arange(N_SAMPLE) / FREQUENCY, rows)
    records = RecordBatch({P1: rows[P1][None]}, FREQUENCY, ("a",))
    (found,) = findings(records, healthy_ranges([P1]))
    assert (found.kind, f"{FREQUENCY / 10:g} Hz" in found.message) == ("stuck", True)


def test_windows_that_touch_no_gap_are_judged(tmp_path):
    healthy = written(tmp_path / "healthy.csv", pressure(60))
    detector = hydrofdi.train(healthy, window="1 s", output="d2", direction="rising", false_alarm_rate="5 %")
    lines = written(tmp_path / "gap.csv", pressure(6)).read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "gap.csv").write_text("".join(lines[:2301] + lines[2501:]), encoding="utf-8")  # 2.3 to 2.5 s
    told = detector.judge(tmp_path / "gap.csv")
    assert told["start"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert told["fault"].tolist() == ["", "", "missing", "", "", ""]
