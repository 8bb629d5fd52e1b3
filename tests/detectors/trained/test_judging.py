"""Windows are judged alike, alone or among others; what forbids to judge, and what an alarm comes to."""

import numpy as np
import pytest

import hydrofdi
from hydrofdi.detectors.configuration import DetectorConfig
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.lines import WindowLine
from hydrofdi.detectors.promise import consequence
from hydrofdi.detectors.rules import make_chart
from hydrofdi.detectors.verdicts import Leak, Verdict
from hydrofdi.errors import Issue
from hydrofdi.indicators import indicator_names
from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk
from tests.detectors.trained.healthy import Records
from tests.detectors.trained.made import FREQUENCY, detector, pressure, window, with_chart, written

HEALTHY = [window(number, seed) for number, seed in enumerate(range(20))]
P1 = HEALTHY[0].channels[Channel.CHAMBER_1_PRESSURE]


def judged(window=HEALTHY[0], **more):
    (verdict,) = Detector(detector(**more)).score([window])
    return verdict


@pytest.mark.parametrize("name", indicator_names())
def test_a_window_is_judged_alike_alone_and_among_others(name):
    number = {"output": "coefficients[5]"} if name == "volterra" else {}  # its other outputs are arrays
    trained = Detector(detector(name, direction="both", ranges=HEALTHY[:5], **number))
    windows = [*HEALTHY[:5], window(5, fault=Issue("is missing", kind="missing"))]
    together = trained.score(windows)
    assert together == [trained.score([each])[0] for each in windows]
    assert trained.score(windows[::-1]) == together[::-1]
    assert trained.score([]) == []


def test_scores_beyond_a_limit_are_alarms_and_those_on_it_are_not():
    score = judged().score
    for low, high, alarm, margin in (
        (None, score, False, 0.0),
        (None, score - 6.0, True, -3.0),
        (score - 6.0, score + 2.0, False, 1.0),
        (score + 4.0, None, True, -2.0),
    ):
        verdict = judged(limits=(low, high), scale=(0.0, 2.0))
        assert (verdict.alarm, verdict.margin) == (alarm, pytest.approx(margin))


def test_faults_of_the_window_come_first():
    stated = Issue("came at 500 Hz instead of 1000 Hz", kind="other_rate")
    verdict = judged(window(n_sample=10, fault=stated, chamber_1_pressure=None), ranges=HEALTHY)
    assert (verdict.fault, verdict.score, verdict.margin, verdict.alarm) == (stated, None, None, None)


def slow(samples):
    return samples[np.arange(samples.size) // 10 * 10]


@pytest.mark.parametrize(("limit", "is_beyond"), [(-1e9, True), (1e9, False)])
@pytest.mark.parametrize(
    ("kind", "words", "samples"),
    [
        ("stuck", "is constant", np.full(1000, 9e6)),
        ("stuck", "at 500 Hz", np.repeat(P1[::2], 2)),
        ("stuck", "at 100 Hz", slow(P1)),
        ("stuck", "at 100 Hz", np.interp(np.arange(1000), np.arange(0, 1000, 10), P1[::10])),
        ("clipped", "at its highest value", np.minimum(P1, 10e6)),
        ("novel", "quantile", P1 + 20e6),
        ("novel", "quantile", 9e6 + 1e-3 * (P1 - 9e6)),
        ("novel", "adjacent samples", P1 + 2e5 * np.random.default_rng(1).standard_normal(1000)),
    ],
)
def test_what_forbids_to_judge_has_its_kind_and_a_novel_window_its_score(
    kind, words, samples, limit, is_beyond
):
    verdict = judged(window(chamber_1_pressure=samples), ranges=HEALTHY, limits=(None, limit))
    assert (verdict.alarm, verdict.fault.kind, words in verdict.fault.message) == (None, kind, True)
    assert (verdict.score is None) == (verdict.margin is None) == (kind != "novel")
    assert verdict.is_beyond is (is_beyond if kind == "novel" else None)


def test_other_windows_of_the_same_kind_are_not_novel_nor_is_what_is_constant_in_healthy_ones():
    verdicts = Detector(detector(ranges=HEALTHY)).score([window(0, 1000 + seed) for seed in range(200)])
    assert all(verdict.fault is None for verdict in verdicts)
    constant = {"chamber_1_pressure": np.full(1000, 9e6)}
    learned = [window(number, **constant) for number in range(5)]
    assert judged(window(**constant), ranges=learned).fault is None


def test_a_score_far_out_on_the_side_without_an_alarm_is_novel():
    score = judged().score
    spread = 1e-3 * abs(score)
    for sign in (-1.0, 1.0):
        # Healthy scores reach five spreads from the median, so scores are novel from twenty spreads on.
        for place, is_novel in ((-4.0, False), (-2.0, False), (19.9, False), (20.1, True), (1e3, True)):
            centre = score - sign * place * spread
            limit, scores = centre - sign * 3.0 * spread, (centre - 5.0 * spread, centre + 5.0 * spread)
            limits = (None, limit) if sign < 0.0 else (limit, None)
            verdict = judged(limits=limits, scale=(centre, spread), scores=scores)
            assert verdict.score == score
            if is_novel:
                assert (verdict.alarm, verdict.is_beyond, verdict.fault.kind) == (None, False, "novel")
            else:
                assert (verdict.alarm, verdict.fault) == (place < -3.0, None)
    middle = score + 9e5
    limits, scores = (score - 1e3, score + 1e6), (middle - 1, middle + 1)
    verdict = judged(limits=limits, scale=(middle, 1.0), scores=scores)
    assert (verdict.alarm, verdict.fault) == (False, None), "no side is without an alarm"


class Told(Detector):
    """A detector that is told the verdicts."""

    def charted(self, verdicts):
        self.verdicts = iter(verdicts)
        samples = np.zeros(1000 * len(verdicts))
        chunk = Chunk(np.arange(samples.size) / FREQUENCY, {Channel.CHAMBER_1_PRESSURE: samples})
        return [line.chart for line in self.step(self.start(), chunk)[1] if isinstance(line, WindowLine)]

    def score(self, windows):
        return [next(self.verdicts) for _ in windows]


SCORES = 10.0 + 2.0 * np.random.default_rng(5).standard_normal(60) + np.repeat([0.0, 3.0], 30)


@pytest.mark.parametrize(("direction", "scores"), [("rising", SCORES), ("falling", 20.0 - SCORES)])
def test_the_chart_is_that_of_standardised_scores_and_passes_over_what_is_not_judged(direction, scores):
    bound = {"rising": (None, 1e9), "falling": (-1e9, None)}[direction]
    file = detector(limits=bound, scale=(10.0, 2.0), direction=direction)
    told = Told(with_chart(file, limit=6.0, direction="rising"))
    verdicts = [Verdict(score, False, 1.0) for score in scores.tolist()]
    found = told.charted(verdicts)
    expected = make_chart("cusum", {"direction": "rising"}).follow((SCORES - 10.0)[None] / 2.0, 6.0)[0]
    np.testing.assert_array_equal([reading.statistic for reading in found], expected)
    assert [reading.alarm for reading in found] == (expected >= 6.0).tolist()
    assert any(reading.alarm for reading in found[30:])
    assert not any(reading.alarm for reading in found[:30])
    novel = Verdict(1e6, None, None, Issue("is novel", kind="novel"))
    lost = Verdict(None, None, None, Issue("is missing", kind="missing"))
    mixed = told.charted([each for verdict in verdicts for each in (novel, verdict, lost)])
    assert mixed[1::3] == found
    assert all(reading.statistic is None and not reading.alarm for reading in mixed[::3] + mixed[2::3])


@pytest.mark.parametrize(
    ("frequency", "stated", "has_chart"),
    [(0.004, {}, True), (0.004, {"chart": None}, False), (4.0, {}, False)],
)
def test_healthy_records_of_a_day_set_up_a_chart_unless_none_is_wanted(frequency, stated, has_chart):
    number = {"indicator": "pressure_statistics", "output": "mean", "direction": "both"}
    window = {"window": {"duration": 4.0 / frequency}}
    config = DetectorConfig.model_validate({**number, **window, "false_alarm_rate": 0.1, **stated})
    means = np.random.default_rng(5).standard_normal((20, 5))
    file = Detector.fit(Records(means, sampling_frequency=frequency), config).file
    assert (file.chart is not None) is has_chart
    assert file.config.chart is None or file.config.chart.false_alarm_every == 86400.0


def test_windows_that_touch_no_gap_are_judged(tmp_path):
    healthy = written(tmp_path / "healthy.csv", pressure(60))
    detector = hydrofdi.train(healthy, window="1 s", output="d2", direction="rising", false_alarm_rate="5 %")
    lines = written(tmp_path / "gap.csv", pressure(6)).read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "gap.csv").write_text("".join(lines[:2301] + lines[2501:]), encoding="utf-8")  # 2.3 to 2.5 s
    told = detector.judge(tmp_path / "gap.csv")
    assert told["start"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert told["fault"].tolist() == ["", "", "missing", "", "", ""]


FLOW = 1e-3 / 60.0  # 1 L/min
LEAK = Leak(FLOW, 0.2 * FLOW)
AREA = {"data_sheet": {"piston_area": 2e-3}}


def numbers(leak, **more):
    return consequence(detector("flow_balance").model_copy(update=more), 100, 30, leak)


def test_an_alarm_states_the_mean_flow_with_its_interval_and_drifts_with_the_area():
    _, found = numbers(LEAK, **AREA)
    assert found["drift_mm_per_min"] == pytest.approx(FLOW / 2e-3 * 6e4) == pytest.approx(500.0)
    assert found["flow_L_per_min"] == pytest.approx(1.0)
    assert found["flow_interval_L_per_min"] == pytest.approx([0.6, 1.4])
    _, found = numbers(Leak(-FLOW, FLOW), **AREA)
    assert found["drift_mm_per_min"] == found["flow_interval_L_per_min"][0] == 0.0
    assert numbers(LEAK, assumed=("piston_area",))[1]["drift_mm_per_min"] is None
    assert numbers(None)[1]["flow_L_per_min"] is numbers(None, **AREA)[1]["drift_mm_per_min"] is None


def test_only_what_chance_does_not_explain_is_news():
    file = detector()
    rate = file.limits.false_alarm_rate
    assert consequence(file, 1000, 1, None)[1]["false_alarms_expected"] == pytest.approx(1000 * rate)
    few, many = (consequence(file, 100, alarms, None)[1]["recommendation"] for alarms in (1, 60))
    assert few.startswith("this may be chance")
    assert many.startswith("more than chance explains")
    assert consequence(file, 100, 1, None, margin=-11.0)[1]["recommendation"] == many
